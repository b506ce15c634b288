#pragma once

#include <vector>

#include "plan/floor_plan.hpp"
#include "plan/free_space.hpp"
#include "plan/room_raster.hpp"
#include "plan/surfels.hpp"
#include "slam/map/keyframe.hpp"

/// The steps of make_plan, in its order.
namespace marco::plan {

/// Finds the faces, largest first: a peak of the Hough transform of the surfels, then least squares
/// over all their points, grown along the line while it is seen. @param aligned  whether the
/// frame's axes are main directions: a face that is parallel to one within 3 sigma, takes it.
/// @param taken  surfels of curved faces, which are left out; empty: none
std::vector<WallFace> find_faces(const std::vector<PlanSurfel>& surfels,
                                 bool aligned,
                                 std::vector<bool> taken = {});

/// Gaps between jambs that beams went through, 0.5 to 3 m wide: both jambs are ends of faces on one
/// line, or (up to 1.3 m) the second is a crossing wall. The space on both sides is wider than the
/// gap, as far as it was seen, so that a corridor's bend is none. Whether it joins two rooms, the
/// rooms decide.
std::vector<PlanOpening> find_openings(const FloorPlan& plan, const FreeSpace& space);

/// Takes door leaves out of the faces: as long as an opening is wide, hinged at a jamb, and free
/// beyond the tip. A face that continues beyond the jamb is cut there; a wall that does so is no
/// leaf, as it is thicker. The openings keep them.
void take_leaves(std::vector<WallFace>& faces,
                 std::vector<PlanOpening>& openings,
                 const FreeSpace& space);

/// The room's edges, exactly: each stretch of its outline is put onto the face or opening that it
/// runs along, and neighbouring lines are joined where they meet. A stretch without a face between
/// two that meet behind it, unseen, becomes their corner (a cupboard stands in it).
/// What stands at a wall goes to the plan's objects.
std::vector<RoomEdge> edges_of(const std::vector<OutlineStep>& outline,
                               FloorPlan& plan,
                               const RoomRaster& raster,
                               const FreeSpace& space);

/// The walls along the rooms' edges: with their thickness where the face behind was seen as well
/// (up to 60 cm away), else with an assumed one.
std::vector<PlanWall> walls_of(const FloorPlan& plan);

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
