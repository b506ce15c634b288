#pragma once

#include <string>

#include "plan/known_plan/plan_sight.hpp"
#include "slam/localization/saved_map.hpp"

namespace marco::plan {

/// A plan as a map to localize in: it is saved, loaded and searched as one that was driven.
slam::SavedMap map_of_plan(const PlanSight& sight);

}  // namespace marco::plan
