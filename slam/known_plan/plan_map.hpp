#pragma once

#include <string>

#include "slam/known_plan/plan_sight.hpp"
#include "slam/localization/saved_map.hpp"

namespace marco::slam {

/// A plan as a map to localize in: it is saved, loaded and searched as one that was driven.
SavedMap map_of_plan(const PlanSight& sight);

}  // namespace marco::slam
