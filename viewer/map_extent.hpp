#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "common/grid_map.hpp"
#include "viewer/cell_areas.hpp"

namespace marco::viewer {

/// The part of a map that a picture shows.
struct MapExtent {
  Eigen::Vector2i min_cell = Eigen::Vector2i::Zero();
  Eigen::Vector2i end_cell = Eigen::Vector2i::Zero();  ///< one past the last cell
  std::size_t cells_beyond = 0;                        ///< known cells outside

  Eigen::Vector2d min_m(const GridMap& grid) const;
  Eigen::Vector2d max_m(const GridMap& grid) const;
};

/// The known cells that neighbouring beams have seen: those in a block of 3 x 3 known cells. A
/// single beam through a window, or one false range, draws a line of free cells one cell wide,
/// which has no such block.
CellMask well_seen(const GridMap& grid);

/// The box of the well seen areas, where that is a tenth smaller than the box of all known cells
/// and costs at most 5 % of them; otherwise the box of all known cells. Well seen areas of less
/// than 1 % do not count.
/// @returns nothing when no cell is known.
std::optional<MapExtent> find_extent(const GridMap& grid);

}  // namespace marco::viewer
