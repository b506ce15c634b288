#pragma once

#include <vector>

#include "slam/map/keyframe.hpp"
#include "slam/plan/floor_plan.hpp"

namespace marco::slam {

/// The floor plan of a finished map. @param keys  its keyframes
/// @throws std::invalid_argument when there are none.
/// Cost: some seconds for a floor of 1000 m2.
FloorPlan make_plan(const std::vector<Keyframe>& keys);

}  // namespace marco::slam
