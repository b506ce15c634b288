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

}  // namespace marco::slam
