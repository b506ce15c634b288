#pragma once

#include <string>
#include <vector>

#include "common/grid_map.hpp"

namespace marco::web {

/// Side of a tile [cells].
inline constexpr int kTileCells = 256;

/// Cuts a map at the multiples of kTileCells cells of the world, so that a map that has grown
/// keeps its tiles. Tiles at the border are as small as the map is there; those in which every cell
/// is unknown are left out. Row by row, y growing.
std::vector<GridMap> cut_tiles(const GridMap& map);

/// Appends {"x_m", "y_m", "width", "height", "png"}: the outer corner of cell (0, 0), size in
/// cells, and a grey PNG of the occupancy bytes in base64. Its first row is the smallest y.
/// @throws std::invalid_argument for a tile without cells.
void append_tile_json(const GridMap& tile, std::string& out);

}  // namespace marco::web
