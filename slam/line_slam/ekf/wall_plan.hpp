#pragma once

#include "common/line_map.hpp"
#include "common/round_wall.hpp"
#include "common/wall.hpp"
#include "slam/line_slam/ekf/wall_map.hpp"

namespace marco::slam {

/// The floor plan: the parts of walls that stand now, at least `min_length_m` long, of walls seen
/// in at least `min_times_seen` scans, with covariances.
Walls plan_of(const WallMap& map, int64_t min_times_seen, double min_length_m);

/// Removes posts that a wall of the plan passes through, along a chord at least as long as their
/// radius: from some viewpoints the corner of a cupboard looks like a post. A column that protrudes
/// from a wall occludes the wall behind it, and stays.
void drop_posts_on_walls(const Walls& plan, RoundWalls& posts);

/// The corners of a floor plan: where the lines of two walls cross by 20 degrees or more, and the
/// end of one and the beginning of the other lie there within their uncertainty. Place and
/// covariance follow from both walls' joint covariance.
/// @param plan  of the same map (plan_of)
CornerPoints corners_of(const WallMap& map, const Walls& plan);

}  // namespace marco::slam
