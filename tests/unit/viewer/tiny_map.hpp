#pragma once

#include <algorithm>

#include "viewer/scene.hpp"

namespace marco::viewer::testing {

/// A map of unknown cells of 5 cm, origin at (-1, -1) m.
inline GridMap unknown_map(double width_m, double height_m) {
  GridMap grid;
  grid.origin_m = {-1.0, -1.0};
  grid.resolution_m = 0.05;
  grid.width_cells = static_cast<int>(width_m / grid.resolution_m);
  grid.height_cells = static_cast<int>(height_m / grid.resolution_m);
  grid.occupancy.assign(static_cast<std::size_t>(grid.width_cells) * grid.height_cells,
                        GridMap::kUnknown);
  return grid;
}

inline void set_cell(GridMap& grid, const Eigen::Vector2i& cell, uint8_t percent) {
  grid.occupancy[static_cast<std::size_t>(cell.y()) * grid.width_cells + cell.x()] = percent;
}

/// Sets the cells whose middles lie in the rectangle.
inline void fill(GridMap& grid,
                 const Eigen::Vector2d& low_m,
                 const Eigen::Vector2d& high_m,
                 uint8_t percent) {
  for (int y = 0; y < grid.height_cells; ++y) {
    for (int x = 0; x < grid.width_cells; ++x) {
      const Eigen::Array2d middle =
          (grid.origin_m + grid.resolution_m * Eigen::Vector2d(x + 0.5, y + 0.5)).array();
      if ((middle > low_m.array()).all() && (middle < high_m.array()).all())
        set_cell(grid, {x, y}, percent);
    }
  }
}

/// A room, free from (0, 0) to (6, 4) m, round it a wall of 10 cm, and in its north-east a pillar
/// from (5, 3) to (5.4, 3.4). Around it 90 cm of nothing known.
inline GridMap room_map() {
  GridMap grid = unknown_map(8.0, 6.0);
  fill(grid, {-0.1, -0.1}, {6.1, 4.1}, 100);
  fill(grid, {0.0, 0.0}, {6.0, 4.0}, 2);
  fill(grid, {5.0, 3.0}, {5.4, 3.4}, 98);
  return grid;
}

/// The room with a path through its middle.
inline Scene room_map_scene() {
  Scene scene;
  scene.grid = room_map();
  PathItem path;
  path.label = "estimate";
  for (int i = 0; i <= 40; ++i)
    path.poses.push_back({Utime::from_us(i), {1.0 + 0.1 * i, 1.5, 0.0}});
  scene.paths.push_back(path);
  return scene;
}

}  // namespace marco::viewer::testing
