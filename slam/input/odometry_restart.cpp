#include "slam/input/odometry_restart.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {

bool odometry_began_anew(const PoseBuffer& odometry, const OdometrySample& sample) {
  constexpr double kFarM = 1.0, kFarMPerS = 5.0, kLongestS = 10.0;
  constexpr double kFarRad = 1.0, kFarRadPerS = 7.0;
  constexpr double kZeroM = 1e-3, kZeroRad = 2e-3, kElsewhereM = 0.05;
  if (odometry.empty()) return false;
  const double dt_s = std::clamp((sample.utime - odometry.newest()).seconds(), 0.0, kLongestS);
  const Pose2& now = sample.odom_from_robot;
  const Pose2 moved = between(odometry.newest_pose(), now);
  const double moved_m = moved.translation_m().norm();
  const bool at_zero = now.translation_m().norm() <= kZeroM && std::abs(now.theta_rad) <= kZeroRad;
  return moved_m > kFarM + kFarMPerS * dt_s ||
         std::abs(moved.theta_rad) > kFarRad + kFarRadPerS * dt_s ||
         (at_zero && moved_m > kElsewhereM);
}

}  // namespace marco::slam
