#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

namespace marco {

/// An occupancy grid as a value: what is drawn, saved and sent.
/// Cells run along the world's axes: cell = floor((p - origin)/resolution), no flips.
struct GridMap {
  static constexpr uint8_t kUnknown = 255;

  Eigen::Vector2d origin_m =
      Eigen::Vector2d::Zero();  ///< world position of cell (0,0)'s outer corner
  double resolution_m = 0.05;
  int width_cells = 0;             ///< along x
  int height_cells = 0;            ///< along y
  std::vector<uint8_t> occupancy;  ///< row by row, y growing; percent occupied 0..100, or kUnknown

  uint8_t at(int x_cell, int y_cell) const {
    return occupancy[static_cast<std::size_t>(y_cell) * static_cast<std::size_t>(width_cells) +
                     static_cast<std::size_t>(x_cell)];
  }
  bool contains(int x_cell, int y_cell) const {
    return x_cell >= 0 && y_cell >= 0 && x_cell < width_cells && y_cell < height_cells;
  }
  Eigen::Vector2i cell_of(const Eigen::Vector2d& point_m) const {
    const Eigen::Vector2d scaled = (point_m - origin_m) / resolution_m;
    return {static_cast<int>(std::floor(scaled.x())), static_cast<int>(std::floor(scaled.y()))};
  }
};

}  // namespace marco
