#pragma once

#include <Eigen/Geometry>

#include "common/pose2.hpp"

namespace marco {

/// A rigid pose in space; `a_from_b` maps b-coordinates into a. x forward, y left, z up.
using Pose3 = Eigen::Isometry3d;

/// Rz(yaw) · Ry(pitch) · Rx(roll), then the translation. Right-handed about y: pitch > 0 looks
/// DOWN.
inline Pose3 make_pose3(const Eigen::Vector3d& translation_m,
                        double roll_rad = 0.0,
                        double pitch_rad = 0.0,
                        double yaw_rad = 0.0) {
  Pose3 pose = Pose3::Identity();
  pose.translation() = translation_m;
  pose.linear() = (Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

/// A turn by a rotation vector [rad] about an axis through `pivot_m`.
inline Pose3 turn_about(const Eigen::Vector3d& pivot_m, const Eigen::Vector3d& rotation_rad) {
  Pose3 turn = Pose3::Identity();
  const double angle_rad = rotation_rad.norm();
  if (angle_rad == 0.0) return turn;
  turn.linear() = Eigen::AngleAxisd(angle_rad, rotation_rad / angle_rad).toRotationMatrix();
  turn.translation() = pivot_m - turn.linear() * pivot_m;
  return turn;
}

/// The floor pose, lifted to z = 0.
inline Pose3 lift(const Pose2& pose) {
  return make_pose3({pose.x_m, pose.y_m, 0.0}, 0.0, 0.0, pose.theta_rad);
}

/// The floor part of a pose: x, y and the heading of its x axis.
inline Pose2 flatten(const Pose3& pose) {
  return {pose.translation().x(), pose.translation().y(),
          std::atan2(pose.linear()(1, 0), pose.linear()(0, 0))};
}

/// The heading of a unit quaternion's x axis.
inline double yaw_of_quaternion(double w, double x, double y, double z) {
  return std::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
}

}  // namespace marco
