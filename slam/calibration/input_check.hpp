#pragma once

#include "slam/calibration/motion_samples.hpp"

namespace marco::slam {

/// How a second measurement of the turns agrees with the laser's.
struct TurnCorrelation {
  double correlation = 0.0;  ///< -1 .. 1, at the best time; 0 where one of both never turns
  double slope = 0.0;        ///< laser's turn over the other's
  double late_s = 0.0;       ///< the other's stamps are so much late
  double sigma_late_s = 0.0;
  bool is_late_found = false;  ///< the best time lies within kMostLateS
  int turns = 0;               ///< motions with more than 3 deg, by the laser
};

/// Shifts the one against the other by up to kMostLateS, in steps of 50 ms, and takes the vertex of
/// the parabola through the best three sums of squares. Their curvature gives its standard
/// deviation.
/// @param motions  known_motions() of `travel`
TurnCorrelation correlate_turns(const std::vector<LaserMotion>& motions,
                                const OdometryTravel& travel);

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
