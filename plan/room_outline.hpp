#pragma once

#include <vector>

#include "plan/floor_plan.hpp"
#include "plan/free_space.hpp"
#include "plan/room_raster.hpp"

namespace marco::plan {

/// The room's edges, exactly: each stretch of its outline is put onto the face or opening that it
/// runs along, and neighbouring lines are joined where they meet. A stretch without a face between
/// two that meet behind it, unseen, becomes their corner (a cupboard stands in it).
/// What stands at a wall goes to the plan's objects.
std::vector<RoomEdge> edges_of(const std::vector<OutlineStep>& outline,
                               FloorPlan& plan,
                               const RoomRaster& raster,
                               const FreeSpace& space);

}  // namespace marco::plan
