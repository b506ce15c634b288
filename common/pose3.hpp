#pragma once

#include <Eigen/Geometry>

#include "common/pose2.hpp"

namespace marco {

/// A rigid pose in space; `a_from_b` maps b-coordinates into a. x forward, y left, z up.
using Pose3 = Eigen::Isometry3d;

/// Rz(yaw) · Ry(pitch) · Rx(roll), then the translation. Right-handed about y: pitch > 0 looks
/// DOWN.
Pose3 make_pose3(const Eigen::Vector3d& translation_m,
                 double roll_rad = 0.0,
                 double pitch_rad = 0.0,
                 double yaw_rad = 0.0);

/// A turn by a rotation vector [rad] about an axis through `pivot_m`.
Pose3 turn_about(const Eigen::Vector3d& pivot_m, const Eigen::Vector3d& rotation_rad);

/// The floor pose, lifted to z = 0.
Pose3 lift(const Pose2& pose);

/// The floor part of a pose: x, y and the heading of its x axis.
Pose2 flatten(const Pose3& pose);

/// The heading of a unit quaternion's x axis.
double yaw_of_quaternion(double w, double x, double y, double z);

}  // namespace marco
