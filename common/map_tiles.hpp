#pragma once

#include <optional>
#include <vector>

#include "common/grid_map.hpp"

namespace marco {

/// Joins the tiles of a map, all of one resolution, into one grid. Cells without a tile are
/// unknown.
/// @returns nothing without tiles, and when the grid would have more than `most_cells`.
std::optional<GridMap> join_tiles(const std::vector<const GridMap*>& tiles, double most_cells);

}  // namespace marco
