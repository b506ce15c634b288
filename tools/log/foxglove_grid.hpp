#pragma once

#include <map>
#include <string>
#include <vector>

#include "lcm_tools/schema/tree.hpp"
#include "marco/grid_map_t.hpp"
#include "tools/log/foxglove_json.hpp"

namespace marco::logs {

/// A foxglove.Grid behind its stamp and frame, drawn as a floor plan: white is free, black
/// occupied, what is unknown is clear.
/// @param occupancy row by row, y growing: 0..100 percent, 255 unknown
std::string floor_plan_json(Eigen::Vector2d origin_m,
                            double resolution_m,
                            int64_t columns,
                            std::span<const uint8_t> occupancy);

constexpr uint64_t kMbotGrid = 0xd5447e494a66cc92;  ///< mbot_lcm_msgs.occupancy_grid_t
/// The same of a message of that type: one field of log odds. "" when it contradicts itself.
std::string mbot_grid_json(const lcm_schema::Tree& tree);

/// Joins the tiles of a map that come as messages of their own. A map is whole when the next tile
/// is of another revision or of a place that is known already, or when no tile came for 50 ms.
/// A map that is as it was is not said again. Memory: the tiles of one map a channel, and its
/// joined cells.
class GridJoiner {
 public:
  /// @param head `{"timestamp":..,"frame_id":..` of the tile's message
  /// @returns the map before, when this tile does not belong to it.
  std::vector<FoxgloveMessage> add(const std::string& channel,
                                   grid_map_t tile,
                                   const std::string& head,
                                   Utime event_time);

  /// Maps that are whole by then.
  std::vector<FoxgloveMessage> finished(Utime now);
  /// All that are left.
  std::vector<FoxgloveMessage> finish();

  /// Maps that are too large to be joined: tiles farther apart than any building is wide.
  int64_t left_out() const { return left_out_; }

 private:
  struct Map {
    std::vector<grid_map_t> tiles;
    std::string head;
    Utime event_time;
    std::string last;  // as it was said last, behind its head
  };
  void say(const std::string& channel, Map& map, std::vector<FoxgloveMessage>& messages);
  std::string joined(const std::vector<grid_map_t>& tiles);

  std::map<std::string, Map> maps_;
  int64_t left_out_ = 0;
};

}  // namespace marco::logs
