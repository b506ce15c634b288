#pragma once

#include <Eigen/Core>
#include <cmath>

namespace marco::slam {

/// A wall as one scan shows it, robot frame, directed: free space (and the sensor) on the left of
/// `start` -> `end`.
///
/// Its line is known by two independent errors at `center_m`: across (offset) and of direction. In
/// the basis (along, across) an end point's covariance is diag(end_sigma^2, across^2 + s^2
/// direction^2), s its distance from the centre.
struct ObservedWall {
  Eigen::Vector2d start_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d end_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();  ///< weighted centre of its points
  double direction_rad = 0.0;
  double across_sigma_m = 0.0;  ///< of the line's offset at the centre
  double direction_sigma_rad = 0.0;
  double start_sigma_m = 0.0;  ///< of `start` along the wall: about the beams' spacing there
  double end_sigma_m = 0.0;
  bool start_seen = false;  ///< a corner or an edge is seen there; false: hidden or cut off
  bool end_seen = false;
  int num_points = 0;
  int first_beam = 0;  ///< its outermost points
  int last_beam = 0;

  Eigen::Vector2d along() const { return {std::cos(direction_rad), std::sin(direction_rad)}; }
  /// Unit normal towards free space.
  Eigen::Vector2d across() const { return {-std::sin(direction_rad), std::cos(direction_rad)}; }
  double length_m() const { return (end_m - start_m).norm(); }
  /// Covariance of (start x, y, end x, y), robot frame.
  Eigen::Matrix4d covariance() const;
};

}  // namespace marco::slam
