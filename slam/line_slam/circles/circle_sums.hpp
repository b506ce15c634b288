#pragma once

#include <Eigen/Core>

namespace marco::slam {

/// Sums over points, from which a circle is fitted without another look at the points: algebraic,
/// by the points' squared distances (Kasa 1976). Radii of short arcs come out too small.
struct CircleSums {
  double count = 0.0;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();      ///< of (x, y, 1)
  Eigen::Vector3d with_square = Eigen::Vector3d::Zero();  ///< of (x, y, 1) (x^2 + y^2)
  double fourth = 0.0;                                    ///< of (x^2 + y^2)^2

  void add_point(const Eigen::Vector2d& point_m);
  CircleSums operator-(const CircleSums& before) const;
};

struct RoughCircle {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
  double rms_m = 0.0;  ///< distance of the points
};

/// Not finite where the points lie on a line, or are fewer than three.
RoughCircle fit_roughly(const CircleSums& sums);

}  // namespace marco::slam
