#pragma once

#include "common/grid_map.hpp"
#include "common/triangle_mesh.hpp"

namespace marco::viewer {

/// Default height of a map's walls [m].
inline constexpr double kWallHeightM = 2.5;

/// A floor plan as rooms: floor (z = 0) where the map is well seen (well_seen), walls of height
/// `wall_height_m` along the outlines of occupied cells, nothing where the map is unknown. Straight
/// stretches of an outline are one face (smooth_outlines); gaps of up to two cells are closed.
/// Areas of occupied cells smaller than 30 cm are left out: a chair's leg or a stray hit.
/// @param wall_height_m 0: only the tops of the walls, on the floor.
/// @returns vertices in the map's frame, with normals and with colours: light floor, dark tops.
TriangleMesh standing_map(const GridMap& grid, double wall_height_m);

/// Whether a cell counts as a wall: above 65 %.
inline bool is_occupied(const GridMap& grid, int x, int y) {
  return grid.at(x, y) > 65 && grid.at(x, y) != GridMap::kUnknown;
}

}  // namespace marco::viewer
