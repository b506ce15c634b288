#pragma once

#include <optional>
#include <vector>

#include "plan/known_plan/plan_sight.hpp"

namespace marco::plan {

/// How a measured map lies in a drawing.
struct PlanFit {
  Pose2 drawing_from_map;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of x, y, theta about the faces' middle
  Eigen::Vector2d middle = {0, 0};                       ///< that middle, in the drawing
  /// Standard deviation of walls that agree, about the drawing: of building, drawing and map.
  double spread_m = 0.0;
  double agreeing = 0.0;  ///< part of the faces' length that lies within 5 cm of what is drawn
};

/// A drawn face that a point belongs to: it faces the same way, and the point lies before or behind
/// it, at most `reach_m`. @returns its index, the nearest one's.
std::optional<std::size_t> drawn_face_at(const std::vector<DrawnFace>& drawn,
                                         const Eigen::Vector2d& point,
                                         const Eigen::Vector2d& normal,
                                         double reach_m);

/// Finds where in a plan a map lies, anywhere in it, as a robot is found in a saved map (see
/// PlaceFinder). @param keys  of the map. @returns nothing where no place stands out.
std::optional<Pose2> find_in_plan(const PlanSight& plan, const std::vector<slam::Keyframe>& keys);

/// Least squares of measured faces on drawn ones, from a guess good to half a metre and some
/// degrees, with a kernel that leaves out what does not agree (Geman and McClure): one wall that
/// was moved does not move the others. Each face counts at both its ends, by its length.
/// @param measured  in the map's frame. @param narrowest_m  the kernel, which narrows from 0.3 m to
/// 0.04 m, stays above this. @throws std::invalid_argument where fewer than three of
/// them lie near what is drawn.
PlanFit fit_to_plan(const std::vector<DrawnFace>& drawn,
                    const std::vector<WallFace>& measured,
                    const Pose2& drawing_from_map_guess,
                    double narrowest_m = 0.0);

/// The same face in another frame.
WallFace moved(const WallFace& face, const Pose2& to_from_frame);

}  // namespace marco::plan
