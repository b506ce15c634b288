#pragma once

#include "common/wall.hpp"
#include "slam/line_slam/ekf/wall_map.hpp"

namespace marco::slam {

/// The floor plan: the parts of walls that stand now, at least `min_length_m` long, of walls seen
/// in at least `min_times_seen` scans, with covariances.
Walls plan_of(WallMap& map, int64_t min_times_seen, double min_length_m);

}  // namespace marco::slam
