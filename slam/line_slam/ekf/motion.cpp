#include "slam/line_slam/ekf/motion.hpp"

#include <cmath>
#include <numbers>

namespace marco::slam {

Eigen::Matrix3d motion_jacobian(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m) {
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian(0, 2) = -(to_m.y() - from_m.y());
  jacobian(1, 2) = to_m.x() - from_m.x();
  return jacobian;
}

Eigen::Matrix3d motion_noise(const MotionNoiseOptions& options,
                             double heading_rad,
                             const Pose2& robot_motion) {
  const double distance_m = robot_motion.translation_m().norm();
  const double turn_rad = std::abs(robot_motion.theta_rad);
  if (distance_m == 0.0 && turn_rad == 0.0) return Eigen::Matrix3d::Zero();
  double psi_rad = distance_m > 0.0 ? std::atan2(robot_motion.y_m, robot_motion.x_m) : 0.0;
  constexpr double kHalfPi = 0.5 * std::numbers::pi;
  if (psi_rad > kHalfPi) psi_rad -= std::numbers::pi;
  if (psi_rad <= -kHalfPi) psi_rad += std::numbers::pi;

  const double along_m = std::hypot(options.distance_sigma_part * distance_m, options.floor_m);
  const double across_m = std::hypot(
      distance_m * std::tan(std::min(1.5, options.direction_sigma_part * std::abs(psi_rad))),
      options.floor_m);
  const double sigma_rad =
      std::hypot(options.heading_sigma_part * turn_rad,
                 options.heading_sigma_rad_per_m * distance_m, options.floor_rad);
  const double c = std::cos(heading_rad + psi_rad), s = std::sin(heading_rad + psi_rad);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  // R_u times the three sigmas, (5.13)
  spread << c * along_m, -s * across_m, 0.0, s * along_m, c * across_m, 0.0, 0.0, 0.0, sigma_rad;
  return spread * spread.transpose();
}

}  // namespace marco::slam
