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
  double weights = 0;  ///< of all points; those without a wall count fully

  Eigen::Matrix3d matrix() const {
    return (Eigen::Matrix3d() << xx, xy, xt, xy, yy, yt, xt, yt, tt).finished();
  }
  Eigen::Vector3d right() const { return {bx, by, bt}; }
};

/// A scan's points and the wall each is tied to: the work of one level of SurfelMatcher. Ties are
/// found anew by tie(); sums over tied points are cheap and made by the vector unit. Coordinates
/// are floats in the robot's frame. Not thread-safe.
class TiedPoints {
 public:
  /// @param every_nth  only every nth point is taken, from the first on
  TiedPoints(const OrientedPoints& points, Eigen::Index every_nth);

  int count() const { return count_; }
  /// Points with a wall at the last tie().
  int tied() const { return tied_; }

  /// Finds each point's wall. @param centre_from_robot  seen from the map's centre.
  void tie(const SurfelMap& map, const Pose2& centre_from_robot);

  /// Sum over the tied points of w n n^T and w n e, with the Lorentzian's weight
  /// w = 1 / (1 + e^2 / 2 sigma^2); the turn is about the robot's own origin.
  NormalSums sum(const Pose2& centre_from_robot, double sigma_m) const;

  /// Distance across its wall of each tied point, at a pose. Points without a wall have NaN.
  void distances_m(const Pose2& centre_from_robot, std::vector<float>& result) const;

 private:
  int count_;
  int tied_ = 0;
  // Padded to whole vectors by points without a wall.
  std::vector<float> x_m_, y_m_, normal_x_, normal_y_;
  std::vector<float> wall_x_, wall_y_, wall_offset_m_;
};

}  // namespace marco::slam
