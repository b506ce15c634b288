#pragma once

#include <vector>

#include "plan/floor_plan.hpp"

namespace marco::plan {

/// The walls along the rooms' edges: with their thickness where the face behind was seen as well
/// (up to 60 cm away), else with an assumed one.
std::vector<PlanWall> walls_of(const FloorPlan& plan);

}  // namespace marco::plan
