#pragma once

#include <vector>

#include "plan/floor_plan.hpp"
#include "plan/room_raster.hpp"
#include "plan/surfels.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::plan {

/// Beyond this size an island in a room is a block of building.
inline constexpr double kLargestObjectM = 3.0;

/// What stands free in the rooms, up to 3 m large: round where a circle fits its hits within 2 cm
/// over at least a third of its turn, else as the hull of its hits.
std::vector<PlanObject> find_objects(const FreeSpace& space,
                                     const RoomRaster& raster,
                                     const std::vector<PlanSurfel>& surfels);

/// Centre and radius of round objects by all rays that hit them, as ranges: points alone would draw
/// the circle too large where rays graze it.
void measure_round(const std::vector<slam::Keyframe>& keyframes,
                   const Pose2& plan_from_map,
                   std::vector<PlanObject>& objects);

}  // namespace marco::plan
