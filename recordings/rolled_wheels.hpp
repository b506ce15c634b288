#pragma once

#include "common/pose2.hpp"

namespace marco {

/// The way of a base whose wheels rolled so far [m]: an arc, seen from its begin.
inline Pose2 rolled(double left_m, double right_m, double track_m) {
  const Pose2 half{0.0, 0.0, 0.5 * ((right_m - left_m) / track_m)};
  return half * Pose2{0.5 * (left_m + right_m), 0.0, 0.0} * half;
}

}  // namespace marco
