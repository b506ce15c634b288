#pragma once

#include "common/pose2.hpp"

namespace marco::slam {

/// How far a predictor of moves was off lately: running means over some twenty scans of the squared
/// error against the moves that scan matching found.
struct PredictionError {
  double m2 = 0.0;
  double rad2 = 0.0;

  /// @param error  (x, y, theta) of the move found, less that predicted
  /// @param position_known  false where the scan left the position open: only the turn is judged
  void update(const Eigen::Vector3d& error, bool position_known);

  template <class Visitor>
  void visit(Visitor& v) {
    v("m2", m2);
    v("rad2", rad2);
  }
};

/// How much of the robot's motion, as scan matching finds it, a sensor explains: for translation
/// and rotation the coefficient of determination, 1 - sum (found - measured)^2 / sum found^2, over
/// steps of about a second; older ones are forgotten over some metres and turns. Near 1 for
/// odometry that is off by a tenth, or late; 0 for one that never changes, and is as good as none;
/// below 0 for a wrong sign.
struct ExplainedMotion {
  double found_m2 = 0.0, missed_m2 = 0.0;
  double found_rad2 = 0.0, missed_rad2 = 0.0;

  /// Takes note of a step; of its translation only where scans know it much better than that, or
  /// a corridor in which matches slide would speak against the wheels.
  /// @param sigma_m  of `found`, along its least known direction
  void update(const Pose2& found, const Pose2& measured, double sigma_m);
  /// At least half of it. A sensor is believed until the robot has moved.
  bool explains_translation() const;
  bool explains_rotation() const;

  template <class Visitor>
  void visit(Visitor& v) {
    v("found_m2", found_m2);
    v("missed_m2", missed_m2);
    v("found_rad2", found_rad2);
    v("missed_rad2", missed_rad2);
  }
};

}  // namespace marco::slam
