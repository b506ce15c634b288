#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/grid_map.hpp"
#include "lcm_tools/base/utime.hpp"
#include "marco/grid_map_t.hpp"

namespace marco {

struct JoinedGrid {
  std::string channel;
  int64_t utime_us = 0;  ///< of its last tile
  Utime event_time;      ///< of its last tile
  GridMap map;
};

/// Collects the tiles of a map, which are messages of their own, into one grid. A map is complete
/// when the next tile has another revision or a known place, or when no tile came for 50 ms. An
/// unchanged map is not repeated. Memory: the tiles of one map for each channel, and its joined
/// cells.
class GridJoiner {
 public:
  /// @returns the previous map, when this tile does not belong to it
  /// @throws std::invalid_argument when the tile contradicts itself
  std::vector<JoinedGrid> add(const std::string& channel, const grid_map_t& tile, Utime event_time);

  /// Maps that are complete by then.
  std::vector<JoinedGrid> finished(Utime now);
  /// All remaining maps.
  std::vector<JoinedGrid> finish();

  /// Maps too large to be joined: their tiles lie farther apart than any building is wide.
  int64_t left_out() const { return left_out_; }

 private:
  struct Map {
    int64_t revision = 0;
    std::vector<GridMap> tiles;
    int64_t utime_us = 0;
    Utime event_time;
    GridMap last;  // given last
  };
  void emit(const std::string& channel, Map& map, std::vector<JoinedGrid>& joined);

  std::map<std::string, Map> maps_;
  int64_t left_out_ = 0;
};

}  // namespace marco
