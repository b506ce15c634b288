#pragma once

#include "slam/calibration/input_check.hpp"
#include "slam/calibration/refinement.hpp"

namespace marco::slam {

/// What odometry's motions miss, where a parameter is not observed.
enum class Missing { nothing, motion, turns, ways, other_arcs, changes_of_speed };
/// For a person, e.g. "turns".
const char* to_string(Missing missing);

struct OdometryFit {
  OdometryCalibration found;  ///< signs included
  Pose2 robot_from_laser;
  RefinedModel model;  ///< the same with covariance; kTrack in metres
  /// By parameter: whether motions that the fit did not see are explained better than with the
  /// parameter as it was assumed.
  std::array<bool, kModelParameters> better{};
  Missing missing = Missing::nothing;  ///< for the geometry
  double error = 0.0;                  ///< mean robust squared error of held-out motions
  double error_before = 0.0;           ///< the same, everything as assumed
  bool ambiguous_front = false;        ///< laser and forward sign could both be the other way round
};

/// Laser, wheels and time from motions; see calibrate_in_closed_form() and refine(). Where the
/// closed form finds too little motion, the search starts from four headings of the laser.
/// @param motions  known_motions() of `travel`; of a laser that is upside down already mirrored
/// @param turns  correlate_turns() of the same; its sign has been explained by `turn_sign`
OdometryFit fit_odometry(const std::vector<LaserMotion>& motions,
                         const OdometryTravel& travel,
                         const TurnCorrelation& turns,
                         double turn_sign,
                         const Pose2& robot_from_laser);

}  // namespace marco::slam
