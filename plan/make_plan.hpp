#pragma once

#include <vector>

#include "plan/floor_plan.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::plan {

/// The floor plan of a finished map. @param keys  its keyframes
/// @throws std::invalid_argument when there are none.
/// Cost: some seconds for a floor of 1000 m2.
FloorPlan make_plan(const std::vector<slam::Keyframe>& keys);

}  // namespace marco::plan
