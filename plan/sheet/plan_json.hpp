#pragma once

#include <string>

#include "plan/floor_plan.hpp"

namespace marco::plan {

/// The plan as a GeoJSON FeatureCollection in metres: rooms are polygons, walls and openings lines,
/// objects polygons or points with a radius. Each feature's `kind` says which, its properties hold
/// areas, widths and one sigma of each. `map_from_plan` turns it into the map's frame.
std::string plan_json(const FloorPlan& plan);

}  // namespace marco::plan
