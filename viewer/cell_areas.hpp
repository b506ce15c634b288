#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace marco::viewer {

/// A flag for each cell of a grid; false beyond it.
class CellMask {
 public:
  CellMask(int width, int height)
      : width_(width), height_(height), cells_(static_cast<std::size_t>(width) * height, 0) {}

  int width() const { return width_; }
  int height() const { return height_; }
  bool at(int x, int y) const {
    return x >= 0 && y >= 0 && x < width_ && y < height_ && cells_[index(x, y)] != 0;
  }
  /// @param x, y must lie inside.
  void set(int x, int y, bool value) { cells_[index(x, y)] = value ? 1 : 0; }
  /// 0 or 1 for each cell, row by row.
  std::vector<uint8_t>& cells() { return cells_; }

 private:
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width_ + x; }

  int width_;
  int height_;
  std::vector<uint8_t> cells_;
};

using CellArea = std::vector<Eigen::Vector2i>;

/// The areas of cells that touch each other, corners included.
std::vector<CellArea> connected_areas(CellMask mask);

/// The cells in blocks of 3 x 3 set cells (morphological opening).
CellMask opened(CellMask mask);
/// Gaps of up to two cells are closed, except at the rim (morphological closing).
CellMask closed(CellMask mask);

/// A block of cells: min corner and one past the max corner.
struct CellRectangle {
  Eigen::Vector2i min_cell;
  Eigen::Vector2i end_cell;
};

/// The mask as few rectangles; every set cell lies in exactly one of them.
std::vector<CellRectangle> cover_by_rectangles(CellMask mask);

}  // namespace marco::viewer
