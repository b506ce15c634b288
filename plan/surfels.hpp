#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/map/keyframe.hpp"

namespace marco::plan {

/// Points of all keyframes that fell into one small cell and face one way, with their moments: a
/// line through surfels is the line through their points.
struct PlanSurfel {
  double count = 0.0;
  Eigen::Vector2d sum = {0, 0};
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  Eigen::Vector2d normal = {0, 0};  ///< sum
  int keyframes = 0;
  int last_keyframe = -1;
  std::vector<Eigen::Vector2d> points;

  Eigen::Vector2d mean() const { return sum / count; }
};

/// @param plan_from_map  turns the keyframes
/// Hits at grazing angles (below 11 degrees) are left out: their footprint is long.
std::vector<PlanSurfel> gather_surfels(const std::vector<slam::Keyframe>& keys,
                                       const Pose2& plan_from_map);

/// The direction modulo 90 degrees that most of the walls have, in [-45, 45) degrees, or NaN where
/// less than a fifth of the surface has it within 3 degrees.
double main_direction_rad(const std::vector<PlanSurfel>& surfels);

}  // namespace marco::plan
