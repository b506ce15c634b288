#pragma once

#include <Eigen/Geometry>

#include "common/covariance.hpp"
#include "common/pose2.hpp"

namespace marco::slam {

/// What the pose owes to scales of odometry that may be wrong, that of distances and that of turns:
/// an error that grows with the way, not with its root, until scans see it. It is part of the
/// pose's covariance and is not estimated ("considered": Schmidt 1966).
struct UnknownScale {
  /// Of wheels that nobody has measured: what is published must hold for them, too.
  static constexpr double kSigma = 0.02;

  /// Of (x, y, theta) in the world, by each of both scales.
  Eigen::Matrix<double, 3, 2> error = Eigen::Matrix<double, 3, 2>::Zero();

  /// By odometry.
  void carry(const Pose2& before, const Pose2& now) {
    const Eigen::Vector2d way_m = now.translation_m() - before.translation_m();
    error.topRows<2>() += Eigen::Vector2d(-way_m.y(), way_m.x()) * error.row(2);
    error.col(0).head<2>() += kSigma * way_m;
    error(2, 1) += kSigma * normalize_angle(now.theta_rad - before.theta_rad);
  }
  /// By a match. @param left  of an error: the covariance after it, times the information before
  void correct(const Eigen::Matrix3d& left) { error = left * error; }
  /// The map, and the robot with it, was turned.
  void turn(double theta_rad) {
    error.topRows<2>() = Eigen::Rotation2Dd(theta_rad) * error.topRows<2>();
  }
  Eigen::Matrix3d covariance() const { return error * error.transpose(); }

  template <class Visitor>
  void visit(Visitor& v) {
    v("error", error);
  }
};

}  // namespace marco::slam
