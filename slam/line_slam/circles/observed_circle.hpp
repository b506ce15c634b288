#pragma once

#include <Eigen/Core>

namespace marco::slam {

/// A post or a curved wall as one scan shows it, robot frame.
struct ObservedCircle {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, radius) [m^2]
  bool from_inside = false;  ///< the sensor looks at it from the centre's side
  double from_rad = 0.0;     ///< direction from the centre to its first point ...
  double span_rad = 0.0;     ///< ... and how far counter-clockwise from there it is seen
  int num_points = 0;
  int first_beam = 0;  ///< its outermost points
  int last_beam = 0;
  /// How much better than a line or a corner of two lines it explains its points: the difference
  /// of their Bayesian information criteria (Schwarz 1978). 10 is decisive.
  double advantage = 0.0;
  bool clear = false;  ///< decisive: a map may take it as new; otherwise only as seen again
};

}  // namespace marco::slam
