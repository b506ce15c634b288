#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "plan/floor_plan.hpp"
#include "plan/surfels.hpp"
#include "slam/line_slam/circles/circle_fit.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::plan {

/// Curved walls of 0.5 m to 15 m radius, and which surfels they take.
struct CurvedFaces {
  RoundWalls arcs;          ///< pieces without a gap; pieces of one circle share its id, from 1 on
  std::vector<bool> taken;  ///< one a surfel
};

/// Grows circles from places where the surface bends, while the surfels lie on them. Kept is what
/// is 1 m long or more, bends by 5 cm or more, and is no chain of two straight walls.
CurvedFaces find_curved_faces(const std::vector<PlanSurfel>& surfels);

/// Fits a circle to all rays of keyframes that hit it, as ranges: points alone would draw it too
/// large where rays graze it. @param start  in the plan's frame @param near_m  of it: its hits
/// @param belongs  of these, by the hit and the ray's direction; all where empty
/// @returns nothing where no circle fits, or one that is farther than `near_m` from `start`
std::optional<slam::FittedCircle> fit_to_hits(
    const std::vector<slam::Keyframe>& keyframes,
    const Pose2& plan_from_map,
    const slam::FittedCircle& start,
    double near_m,
    const std::function<bool(const Eigen::Vector2d& hit, const Eigen::Vector2d& ray)>& belongs =
        {});

/// Circles of arcs by all rays that hit them.
void measure_arcs(const std::vector<slam::Keyframe>& keyframes,
                  const Pose2& plan_from_map,
                  RoundWalls& arcs);

/// Chords of arcs, 0.3 m long or more, for who takes straight faces only.
std::vector<WallFace> chords_of_arcs(const RoundWalls& arcs);

/// Puts edges that run along chords of one circle onto it, as one edge.
void bend_edges(std::vector<RoomEdge>& loop, const FloorPlan& plan);

}  // namespace marco::plan
