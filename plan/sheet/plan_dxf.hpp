#pragma once

#include <string>

#include "plan/floor_plan.hpp"

namespace marco::plan {

/// The plan for CAD programs: DXF R12, in metres ($INSUNITS 6), on layers WALLS, WALLS_UNSEEN,
/// DOORS (inserts of the blocks DOOR and OPENING, one unit wide), ROOMS, DIMENSIONS, COLUMNS and
/// FURNITURE. Frame: the plan's.
std::string plan_dxf(const FloorPlan& plan);

}  // namespace marco::plan
