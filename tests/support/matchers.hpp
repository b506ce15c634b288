#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <ostream>

#include "common/pose2.hpp"

namespace marco {

inline void PrintTo(const Pose2& pose, std::ostream* out) {
  *out << "(" << pose.x_m << " m, " << pose.y_m << " m, " << pose.theta_rad << " rad)";
}

namespace testing {

/// Within tol_m in position and tol_rad in heading.
MATCHER_P3(IsNear, expected, tol_m, tol_rad, "") {
  const double distance_m = std::hypot(arg.x_m - expected.x_m, arg.y_m - expected.y_m);
  const double angle_rad = std::abs(normalize_angle(arg.theta_rad - expected.theta_rad));
  *result_listener << "which is " << distance_m << " m and " << angle_rad << " rad away";
  return distance_m <= tol_m && angle_rad <= tol_rad;
}

}  // namespace testing
}  // namespace marco
