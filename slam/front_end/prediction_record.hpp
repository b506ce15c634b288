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

/// The error of odometry's way per metre, learned from steps of about a second that scan matching
/// knows much better: a maximum a posteriori estimate, with ten steps of odometry as it is assumed
/// to be at first.
struct OdometryNoise {
  double steps = 0.0;       ///< those that are remembered
  double off2 = 0.0;        ///< sum of their squared errors per metre, along one axis
  double off_ahead2 = 0.0;  ///< along the way: a heading that is counted wrong hardly enters

  /// Takes note of a step. @param sigma_m  of `found`, along its least known direction
  void update(const Pose2& found, const Pose2& measured, double sigma_m, double assumed_per_m);
  /// Standard deviation along one axis, per metre driven: never more than assumed.
  double sigma_per_m(double assumed_per_m) const { return learned_per_m(off2, assumed_per_m); }
  /// Along the way; of a skid-steered robot much less than along any axis.
  double ahead_per_m(double assumed_per_m) const {
    return learned_per_m(off_ahead2, assumed_per_m);
  }

  template <class Visitor>
  void visit(Visitor& v) {
    v("steps", steps);
    v("off2", off2);
    v("off_ahead2", off_ahead2);
  }

 private:
  double learned_per_m(double errors2, double assumed_per_m) const;
};

}  // namespace marco::slam
