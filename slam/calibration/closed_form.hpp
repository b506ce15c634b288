#pragma once

#include <optional>

#include "slam/calibration/robot_model.hpp"

namespace marco::slam {

struct ClosedFormResult {
  RobotModel model;
  /// Larger over smaller eigenvalue of what fixes the laser's heading: near 1 it is a guess.
  double heading_ratio = 0.0;
  std::vector<MotionSample> kept;  ///< without those that were dropped as worst
};

/// Wheels, track and laser from scratch (Censi, Franchi, Marchionni and Oriolo 2013). The angles
/// give both wheels' scales over the track by linear least squares. The positions then give track
/// and laser: a quadratic form in (track, x, y, cos yaw, sin yaw), least where the last two have
/// unit length. The authors solve for the multiplier; the smaller eigenvector of the Schur
/// complement is the same minimum. Four times the worst 1 % in angle or position is dropped.
/// The robot's frame is taken to be the axle's. The track is positive; scales may be negative.
/// @returns nothing where the motions cannot tell the two wheels apart: straight only, turns on the
/// spot only, one arc only (the condition number is above 75).
std::optional<ClosedFormResult> calibrate_in_closed_form(std::vector<MotionSample> samples);

}  // namespace marco::slam
