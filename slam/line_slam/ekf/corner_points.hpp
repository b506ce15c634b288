#pragma once

#include "common/line_map.hpp"
#include "slam/line_slam/ekf/wall_map.hpp"

namespace marco::slam {

/// The corners of a floor plan: where the lines of two walls cross by 20 degrees or more, and the
/// end of one and the beginning of the other lie there within their uncertainty. Place and
/// covariance follow from both walls' joint covariance.
/// @param plan  of the same map (plan_of)
CornerPoints corners_of(const WallMap& map, const Walls& plan);

}  // namespace marco::slam
