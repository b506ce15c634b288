#include "common/pose3.hpp"

#include <cmath>

namespace marco {

Pose3 make_pose3(const Eigen::Vector3d& translation_m,
                 double roll_rad,
                 double pitch_rad,
                 double yaw_rad) {
  Pose3 pose = Pose3::Identity();
  pose.translation() = translation_m;
  pose.linear() = (Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

Pose3 turn_about(const Eigen::Vector3d& pivot_m, const Eigen::Vector3d& rotation_rad) {
  Pose3 turn = Pose3::Identity();
  const double angle_rad = rotation_rad.norm();
  if (angle_rad == 0.0) return turn;
  turn.linear() = Eigen::AngleAxisd(angle_rad, rotation_rad / angle_rad).toRotationMatrix();
  turn.translation() = pivot_m - turn.linear() * pivot_m;
  return turn;
}

Pose3 lift(const Pose2& pose) {
  return make_pose3({pose.x_m, pose.y_m, 0.0}, 0.0, 0.0, pose.theta_rad);
}

Pose2 flatten(const Pose3& pose) {
  return {pose.translation().x(), pose.translation().y(),
          std::atan2(pose.linear()(1, 0), pose.linear()(0, 0))};
}

double yaw_of_quaternion(double w, double x, double y, double z) {
  return std::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
}

}  // namespace marco
