#pragma once

#include <string>

#include "plan/floor_plan.hpp"

namespace marco::plan {

/// The plan as a GeoJSON FeatureCollection in metres: rooms are polygons, walls and openings lines,
/// objects polygons or points with a radius. Each feature's `kind` says which, its properties hold
/// areas, widths and one sigma of each. `map_from_plan` turns it into the map's frame.
std::string plan_json(const FloorPlan& plan);

/// The plan for CAD programs: DXF R12, in metres ($INSUNITS 6), on layers WALLS, WALLS_UNSEEN,
/// DOORS (inserts of the blocks DOOR and OPENING, one unit wide), ROOMS, DIMENSIONS, COLUMNS and
/// FURNITURE. Frame: the plan's.
std::string plan_dxf(const FloorPlan& plan);

}  // namespace marco::plan
