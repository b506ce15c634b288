#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/pose2.hpp"
#include "common/round_wall.hpp"
#include "plan/bulge.hpp"

namespace marco::plan {

/// One side of a wall, as the laser saw it: a straight line that was fitted to all points of all
/// keyframes. Frame: the plan's.
struct WallFace {
  Eigen::Vector2d normal = {1, 0};  ///< unit, towards the side it was seen from
  double offset_m = 0.0;            ///< normal . x = offset
  double low_m = 0.0;               ///< where it begins and ends, measured by along() . x
  double high_m = 0.0;
  double sigma_m = 0.0;  ///< of the offset, at the middle
  double angle_sigma_rad = 0.0;
  int keyframes = 0;   ///< that saw it, at its middle
  bool glass = false;  ///< beams went through it as well: glass, or lower than the laser in places
  bool aligned = false;  ///< takes a main direction of the building, which lies within its sigma
  int64_t circle = 0;    ///< id of the curved wall (FloorPlan::arcs) that it is a chord of; 0: none

  Eigen::Vector2d along() const { return {-normal.y(), normal.x()}; }
  Eigen::Vector2d at(double along_m) const { return normal * offset_m + along() * along_m; }
  double length_m() const { return high_m - low_m; }
  /// Above 0 on the side it was seen from.
  double distance_m(const Eigen::Vector2d& point) const { return normal.dot(point) - offset_m; }
};

/// What an edge of a room is.
enum class EdgeKind {
  wall,     ///< a face, seen
  unseen,   ///< nobody looked there, or something stands in front: drawn dashed
  opening,  ///< the line on which a door or a wide opening is closed
};

/// A room's edge.
struct RoomEdge {
  Eigen::Vector2d from = {0, 0};
  Eigen::Vector2d to = {0, 0};  ///< where the next one of its loop begins
  EdgeKind kind = EdgeKind::wall;
  int index = -1;      ///< of the face or of the opening
  double bulge = 0.0;  ///< of a curved wall, see bulge.hpp
  double length_m() const { return bulge_length_m(from, to, bulge); }
};

struct PlanRoom {
  std::string name;
  /// Round the room counter-clockwise; then, clockwise, round each block of other rooms inside it.
  std::vector<std::vector<RoomEdge>> loops;
  double area_m2 = 0.0;  ///< net, between the faces
  double area_sigma_m2 = 0.0;
  double perimeter_m = 0.0;
  Eigen::Vector2d label_at = {0, 0};  ///< well inside
  std::vector<RoomEdge> edges() const {
    std::vector<RoomEdge> all;
    for (const auto& loop : loops) all.insert(all.end(), loop.begin(), loop.end());
    return all;
  }
  Eigen::Vector2d size_m = {0, 0};     ///< clear, through the label: along x, along y
  Eigen::Vector2d size_from = {0, 0};  ///< where these begin: x on the label's level, y below it
  double seen = 0.0;                   ///< part of the perimeter that is seen wall or opening
};

/// A gap in a wall that was seen or driven through.
struct PlanOpening {
  Eigen::Vector2d from = {0, 0};  ///< jambs
  Eigen::Vector2d to = {0, 0};
  double width_m() const { return (to - from).norm(); }
  double sigma_m = 0.0;   ///< of the width
  double depth_m = 0.0;   ///< to the wall's other face, on the right of from -> to; 0: none seen
  bool has_leaf = false;  ///< a door leaf was seen, standing open
  Eigen::Vector2d hinge = {0, 0};
  Eigen::Vector2d leaf_end = {0, 0};
  Eigen::Vector2d right() const {
    return Eigen::Vector2d(to.y() - from.y(), from.x() - to.x()).normalized();
  }
  bool is_door() const { return width_m() <= 2.2; }
};

/// A wall of which both faces were seen, between two rooms or inside one.
struct PlanWall {
  Eigen::Vector2d from = {0, 0};  ///< on the first face
  Eigen::Vector2d to = {0, 0};
  Eigen::Vector2d normal = {0, 1};  ///< from the other face to the first one
  double thickness_m = 0.0;         ///< to the other face; where `assumed`, for the drawing alone
  bool assumed = false;             ///< only one face was seen
  double bulge = 0.0;               ///< of a curved one; `normal` is then that of its middle
  /// The point of the other face behind one of the first face.
  Eigen::Vector2d back(const Eigen::Vector2d& at) const {
    if (bulge == 0.0) return at - normal * thickness_m;
    const BulgeArc arc = bulge_arc(from, to, bulge);
    const Eigen::Vector2d out = (at - arc.centre) / arc.radius;
    const bool from_inside = normal.dot(arc.at(0.5) - arc.centre) < 0;
    return at + out * (from_inside ? thickness_m : -thickness_m);
  }
};

/// What stands free in a room: columns where round, else furniture.
struct PlanObject {
  std::vector<Eigen::Vector2d> outline;
  bool round = false;
  Eigen::Vector2d centre = {0, 0};
  double radius_m = 0.0;
  double radius_sigma_m = 0.0;  ///< 0: not measured
};

struct FloorPlan {
  Pose2 map_from_plan;  ///< the plan is turned so that most walls lie level or upright
  bool has_main_direction = false;
  std::vector<WallFace> faces;  ///< of curved walls their chords
  RoundWalls arcs;              ///< curved faces; pieces of one circle share its id
  std::vector<PlanOpening> openings;
  std::vector<PlanRoom> rooms;
  std::vector<PlanWall> walls;
  std::vector<PlanObject> objects;
  double scale_sigma = 0.0;  ///< of the map's scale, relative: all lengths share it
};

}  // namespace marco::plan
