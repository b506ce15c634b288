#include "lcmtypes/grid_joiner.hpp"

#include <algorithm>

#include "common/map_tiles.hpp"
#include "lcmtypes/convert.hpp"

namespace marco {
namespace {

// Tiles cover a map; some may be lost.
constexpr double kMostPerTileCell = 16;
constexpr double kMostCells = 1 << 25;  // 290 m x 290 m of 5 cm
constexpr Duration kPatience = Duration::from_us(50000);

// Nothing when the tiles lie too far apart.
std::optional<GridMap> joined(const std::vector<GridMap>& tiles) {
  std::vector<const GridMap*> pointers;
  double tile_cells = 0;
  for (const GridMap& tile : tiles) {
    pointers.push_back(&tile);
    tile_cells += static_cast<double>(tile.occupancy.size());
  }
  return join_tiles(pointers, std::min(kMostCells, kMostPerTileCell * tile_cells));
}

bool are_same(const GridMap& a, const GridMap& b) {
  return a.origin_m == b.origin_m && a.resolution_m == b.resolution_m &&
         a.width_cells == b.width_cells && a.occupancy == b.occupancy;
}

}  // namespace

std::vector<JoinedGrid> GridJoiner::add(const std::string& channel,
                                        const grid_map_t& message,
                                        Utime event_time) {
  GridMap tile = from_message(message);
  std::vector<JoinedGrid> grids;
  Map& map = maps_[channel];
  const bool belongs = std::all_of(map.tiles.begin(), map.tiles.end(), [&](const auto& other) {
    return map.revision == message.revision && other.resolution_m == tile.resolution_m &&
           other.origin_m != tile.origin_m;
  });
  if (!belongs) emit(channel, map, grids);
  map.revision = message.revision;
  map.tiles.push_back(std::move(tile));
  map.utime_us = message.utime;
  map.event_time = event_time;
  return grids;
}

std::vector<JoinedGrid> GridJoiner::finished(Utime now) {
  std::vector<JoinedGrid> grids;
  for (auto& [channel, map] : maps_) {
    // Event times may step back a little.
    const bool is_late = now - map.event_time > kPatience || map.event_time - now > kPatience;
    if (!map.tiles.empty() && is_late) emit(channel, map, grids);
  }
  return grids;
}

std::vector<JoinedGrid> GridJoiner::finish() {
  std::vector<JoinedGrid> grids;
  for (auto& [channel, map] : maps_) {
    if (!map.tiles.empty()) emit(channel, map, grids);
  }
  return grids;
}

void GridJoiner::emit(const std::string& channel, Map& map, std::vector<JoinedGrid>& grids) {
  std::optional<GridMap> whole = joined(map.tiles);
  map.tiles.clear();
  if (!whole) {
    ++left_out_;
    return;
  }
  if (are_same(*whole, map.last)) return;
  map.last = *whole;
  grids.push_back({channel, map.utime_us, map.event_time, std::move(*whole)});
}

}  // namespace marco
