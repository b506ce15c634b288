#pragma once

#include "slam/calibration/turn_correlation.hpp"

namespace marco::slam {

/// What is wrong with a second measurement of the motion, by the laser's.
enum class InputState {
  none,      ///< there is no such input, or the laser hardly moved while there was
  good,      ///< it moves as the laser does
  constant,  ///< it never moves
  stalled,   ///< it stands still for more than a twentieth of the motions; good otherwise
  foreign,   ///< it turns unlike the laser does: another robot's, or noise
};
/// For a person, e.g. "never moves".
const char* to_string(InputState state);

/// What is measured besides the laser: of a gyroscope, only turns count.
enum class InputKind { odometry, gyro };

struct InputCheck {
  InputState state = InputState::none;
  TurnCorrelation turns;            ///< of `moving`
  std::vector<LaserMotion> moving;  ///< without those it stood still in
  double stalled_share = 0.0;       ///< of the motions of the laser
};

/// @param motions  known_motions() of `travel`
InputCheck check_input(const std::vector<LaserMotion>& motions,
                       const OdometryTravel& travel,
                       InputKind kind);

}  // namespace marco::slam
