#pragma once

#include "slam/line_slam/ekf/data_association.hpp"
#include "slam/line_slam/ekf/wall_map.hpp"

namespace marco::slam {

/// (5.3.1) Moves the ends of a map wall out to where the observed one ends farther on.
void extend_wall(WallMap& map, std::size_t index, const ObservedWall& observed);

/// (5.3.1) Makes one wall of two: both are measured to lie on one line, the outermost ends stay,
/// the others are marginalized. Wall b is removed: the last wall takes its index.
void join_walls(WallMap& map, std::size_t a, std::size_t b);

/// Joins matched walls with active ones that resemble them and pass the innovation gate.
/// @returns how many.
int join_similar_walls(WallMap& map, const std::vector<WallMatch>& matches);

}  // namespace marco::slam
