#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/grid_map.hpp"
#include "lcm_tools/log/mcap_translator.hpp"
#include "marco/grid_map_t.hpp"
#include "tools/log/foxglove_json.hpp"

namespace marco::logs {

/// The fields of a foxglove.Grid after its stamp and frame: free is white, occupied black, unknown
/// transparent.
std::string floor_plan_json(const GridMap& map);

constexpr uint64_t kMbotGrid = 0xd5447e494a66cc92;  ///< mbot_lcm_msgs.occupancy_grid_t
/// The same for a message of that type: one field of log odds. "" when it contradicts itself.
std::string mbot_grid_json(const lcm_schema::Tree& tree);

/// Collects the tiles of a map, which are messages of their own, into one foxglove.Grid. A map is
/// complete when the next tile has another revision or a known place, or when no tile came for
/// 50 ms. An unchanged map is not repeated. Memory: the tiles of one map for each channel, and its
/// joined cells.
class GridJoiner {
 public:
  /// @param head `{"timestamp":..,"frame_id":..` of the tile's message
  /// @returns the previous map, when this tile does not belong to it
  /// @throws std::invalid_argument when the tile contradicts itself
  std::vector<AddedMessage> add(const std::string& channel,
                                const grid_map_t& tile,
                                const std::string& head,
                                Utime event_time);

  /// Maps that are complete by then.
  std::vector<AddedMessage> finished(Utime now);
  /// All remaining maps.
  std::vector<AddedMessage> finish();

  /// Maps too large to be joined: their tiles lie farther apart than any building is wide.
  int64_t left_out() const { return left_out_; }

 private:
  struct Map {
    int64_t revision = 0;
    std::vector<GridMap> tiles;
    std::string head;
    Utime event_time;
    std::string last;  // written last, without its head
  };
  void emit(const std::string& channel, Map& map, std::vector<AddedMessage>& messages);

  std::map<std::string, Map> maps_;
  int64_t left_out_ = 0;
};

}  // namespace marco::logs
