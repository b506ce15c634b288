#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/matching/oriented_points.hpp"
#include "slam/matching/surfel_map.hpp"

namespace marco::slam {

/// Upper triangle of the normal equations in (x, y, theta) and the right-hand side.
struct NormalSums {
  double xx = 0, xy = 0, xt = 0, yy = 0, yt = 0, tt = 0;
  double bx = 0, by = 0, bt = 0;
  double weights = 0;  ///< of all points; those without a correspondence have weight 1

  Eigen::Matrix3d matrix() const {
    return (Eigen::Matrix3d() << xx, xy, xt, xy, yy, yt, xt, yt, tt).finished();
  }
  Eigen::Vector3d right() const { return {bx, by, bt}; }
};

/// Data association of one level of SurfelMatcher: a scan's points and the surfel each corresponds
/// to. associate() searches them; the sums over correspondences use the vector unit. Coordinates
/// are floats in the robot's frame. Not thread-safe.
class Correspondences {
 public:
  /// @param every_nth  takes every nth point, beginning with the first
  Correspondences(const OrientedPoints& points, Eigen::Index every_nth);

  int count() const { return count_; }
  /// Points with a correspondence since the last associate().
  int matched() const { return matched_; }

  /// Finds each point's surfel. @param centre_from_robot  relative to the map's centre.
  void associate(const SurfelMap& map, const Pose2& centre_from_robot);

  /// Sum over the correspondences of w n n^T and w n e, with the robust kernel's weight
  /// (Lorentzian) w = 1 / (1 + e^2 / 2 sigma^2); the turn is about the robot's own origin.
  NormalSums sum(const Pose2& centre_from_robot, double sigma_m) const;

  /// Distance of each point from its surfel's line at a pose; NaN without a correspondence.
  void distances_m(const Pose2& centre_from_robot, std::vector<float>& result) const;

 private:
  int count_;
  int matched_ = 0;
  // Padded to whole vectors by points without a correspondence.
  std::vector<float> x_m_, y_m_, normal_x_, normal_y_;
  std::vector<float> wall_x_, wall_y_, wall_offset_m_;
};

}  // namespace marco::slam
