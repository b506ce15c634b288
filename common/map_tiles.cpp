#include "common/map_tiles.hpp"

#include <algorithm>

namespace marco {

std::optional<GridMap> join_tiles(const std::vector<const GridMap*>& tiles, double most_cells) {
  if (tiles.empty()) return std::nullopt;
  GridMap all;
  all.resolution_m = tiles.front()->resolution_m;
  Eigen::Vector2d low_m = Eigen::Vector2d::Constant(HUGE_VAL), high_m = -low_m;
  for (const GridMap* tile : tiles) {
    const Eigen::Vector2d size(tile->width_cells, tile->height_cells);
    low_m = low_m.cwiseMin(tile->origin_m);
    high_m = high_m.cwiseMax(tile->origin_m + all.resolution_m * size);
  }
  const Eigen::Vector2d size = ((high_m - low_m) / all.resolution_m).array().round();
  if (!(size.x() * size.y() <= most_cells)) return std::nullopt;
  all.origin_m = low_m;
  all.width_cells = static_cast<int>(size.x());
  all.height_cells = static_cast<int>(size.y());
  all.occupancy.assign(static_cast<std::size_t>(size.x() * size.y()), GridMap::kUnknown);
  for (const GridMap* tile : tiles) {
    const Eigen::Vector2d at = ((tile->origin_m - low_m) / all.resolution_m).array().round();
    const auto x = static_cast<std::ptrdiff_t>(at.x()), y = static_cast<std::ptrdiff_t>(at.y());
    // Rounding may put a tile that lies off the raster past the edge.
    if (x + tile->width_cells > all.width_cells || y + tile->height_cells > all.height_cells) {
      continue;
    }
    for (std::ptrdiff_t row = 0; row < tile->height_cells; ++row) {
      const auto from = tile->occupancy.begin() + row * tile->width_cells;
      std::copy(from, from + tile->width_cells,
                all.occupancy.begin() + (y + row) * all.width_cells + x);
    }
  }
  return all;
}

}  // namespace marco
