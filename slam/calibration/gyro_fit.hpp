#pragma once

#include <array>

#include "slam/calibration/input_check.hpp"

namespace marco::slam {

struct GyroFit {
  TurnCorrelation turns;
  GyroCalibration found;
  GyroCalibration sigma;  ///< standard deviations
  /// Scale, bias, time: whether motions held out are explained better than without it.
  std::array<bool, 3> better{};
};

/// What makes a gyroscope's turns those of the laser: robust least squares over scale, bias and
/// time together, from correlate_turns() on.
/// @param motions  known_motions() of `travel`
/// @param travel  the integrated rate as poses that only turn
GyroFit fit_gyro(const std::vector<LaserMotion>& motions, const OdometryTravel& travel);

}  // namespace marco::slam
