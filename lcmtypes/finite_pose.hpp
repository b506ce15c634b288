#pragma once

#include <cmath>

#include "common/pose2.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco {

/// The pose in a received message. @throws std::invalid_argument with `what` when it is not finite,
/// or farther away than any building is wide.
inline Pose2 finite_pose(double x_m, double y_m, double theta_rad, const char* what) {
  const Pose2 pose{x_m, y_m, normalize_angle(theta_rad)};
  // Farther than any building is wide: a flipped bit, not a place.
  constexpr double kFarthestM = 1e5;
  require(is_finite(pose) && std::abs(x_m) < kFarthestM && std::abs(y_m) < kFarthestM, what);
  return pose;
}

}  // namespace marco
