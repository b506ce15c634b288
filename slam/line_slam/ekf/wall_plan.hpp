#pragma once

#include "common/round_wall.hpp"
#include "common/wall.hpp"
#include "slam/line_slam/ekf/wall_map.hpp"

namespace marco::slam {

/// The floor plan: the parts of walls that stand now, at least `min_length_m` long, of walls seen
/// in at least `min_times_seen` scans, with covariances.
Walls plan_of(WallMap& map, int64_t min_times_seen, double min_length_m);

/// Drops posts that a wall of the plan runs through, over a chord as long as their radius: the
/// corner of a cupboard looks like one, from some places. A column that sticks out of a wall hides
/// the wall behind it, and stays.
void drop_posts_on_walls(const Walls& plan, RoundWalls& posts);

}  // namespace marco::slam
