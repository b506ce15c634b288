#pragma once

#include <Eigen/Core>

namespace marco::slam {

/// Standard deviation of the normals of a scan's points [rad]. Their noise makes a bare corridor
/// look constrained along itself.
inline constexpr double kNormalSigma = 0.06;

/// The direction of translation that a sum of point-to-line constraints, w j j^T with
/// j = (n_x, n_y, arm x n), constrains least; the heading is marginalized.
struct WeakestDirection {
  Eigen::Vector2d direction;  ///< unit length
  double information;         ///< along it, at least 0
  /// The part that the noise of normals explains: kNormalSigma^2 sum w (t . direction)^2, t along
  /// the wall. At most `information`.
  double by_noise;

  explicit WeakestDirection(const Eigen::Matrix3d& sum);

  double honest() const { return information - by_noise; }
  /// The sum without by_noise; positive semidefinite as the sum was.
  Eigen::Matrix3d without_noise(Eigen::Matrix3d sum) const {
    sum.topLeftCorner<2, 2>() -= by_noise * direction * direction.transpose();
    return sum;
  }
};

}  // namespace marco::slam
