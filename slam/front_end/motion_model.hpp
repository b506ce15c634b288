#pragma once

#include <cstdint>
#include <optional>

#include "common/input/synchronized_scan.hpp"
#include "slam/front_end/dead_reckoning.hpp"
#include "slam/front_end/motion_guess.hpp"
#include "slam/front_end/odometry_errors.hpp"
#include "slam/front_end/prediction_record.hpp"

namespace marco::slam {

/// A robot's velocity during a scan.
struct ScanVelocity {
  Velocity2 velocity;
  bool by_odometry = false;  ///< else it was predicted: its own match knows better
};

/// What a MotionModel remembers.
struct MotionState {
  std::optional<MotionInput> before;
  DeadReckoningState reckoning;
  double move_m = 0.0;  ///< from one scan to the next, a running mean
  double turn_rad = 0.0;
  ExplainedMotion explained_by_odometry, explained_by_gyro;
  PredictionError odometry_error, gyro_error, reckoning_error;
  bool odometry_has_moved = false;  ///< one that never does is as good as none
  OdometryNoise odometry_noise;
  /// Where the step began that is to be explained next, and the way from there to the newest scan.
  std::optional<MotionInput> step_start;
  Pose2 start_from_now;
  double step_start_sigma_m = 0.0;  ///< of the match there

  template <class Visitor>
  void visit(Visitor& v) {
    v("before", before);
    v("reckoning", reckoning);
    v("move_m", move_m);
    v("turn_rad", turn_rad);
    v("explained_by_odometry", explained_by_odometry);
    v("explained_by_gyro", explained_by_gyro);
    v("odometry_error", odometry_error);
    v("gyro_error", gyro_error);
    v("reckoning_error", reckoning_error);
    v("odometry_has_moved", odometry_has_moved);
    v.template before<Eigen::Vector3d>(kDriftLayout, "odometry_noise");
    v.since(kDriftLayout, "learned_odometry_noise", odometry_noise);
    v("step_start", step_start);
    v("start_from_now", start_from_now);
    v("step_start_sigma_m", step_start_sigma_m);
  }
};

/// Predicts each scan's move: by odometry and gyro where they explain the motion that scan matching
/// finds, else by dead reckoning. Odometry that is constant, has a wrong sign or belongs to another
/// robot is as good as none, and a gyro of unknown sign and unit counts only where it is right.
/// Stamps and odometry are those that SensorSynchronizer has repaired. Not thread-safe.
class MotionModel {
 public:
  explicit MotionModel(const MotionOptions& options = {});

  /// The move from the scan before to this one. Changes nothing.
  /// @param will_match  a match will judge it: odometry that has never moved is left out
  MotionGuess guess(const MotionInput& now, bool will_match = true) const;
  /// The same by dead reckoning alone: the constant-velocity prediction.
  MotionGuess guess_by_velocity(const MotionInput& now) const;

  /// As it was learned; DriftFilter teaches it.
  OdometryNoise& odometry_noise() { return state_.odometry_noise; }

  /// Whether odometry says that the robot has not moved, and recent scans agree, as far as they can
  /// tell. @param information  of this scan's match
  bool stands_still(const MotionInput& now, const Eigen::Matrix3d& information) const;
  /// False once scans have shown that odometry explains less than half of the motion.
  bool trusts_odometry() const;

  /// The innovation gate: whether `moved`, between the scan before and `now`, exceeds the limits of
  /// MotionOptions by 0.3 m or 30 degrees.
  bool exceeds_motion_limits(const Pose2& moved, Utime now) const;
  /// The scan before's time; only after an update.
  Utime newest() const { return state_.before->utime; }

  /// Takes note of this scan's input and of the move that was found.
  /// @param matched  it was found by a scan: it judges what was predicted
  /// @param covariance  of that match, in the robot's frame before
  void update(const MotionInput& now,
              const Pose2& before_from_now,
              bool matched = true,
              const Eigen::Matrix3d& covariance = Eigen::Matrix3d::Zero());

  /// To deskew the next scan by: odometry's, if the scan is long and odometry is trusted, else that
  /// of the last scans, smoothed over two at least.
  /// @param odometry_step  from the scan's first beam to its last, where it is known
  ScanVelocity velocity_during(const std::optional<Pose2>& odometry_step, double duration_s) const;
  /// That a match shows: see DeadReckoning.
  std::optional<Velocity2> velocity_to(Utime now, const Pose2& before_from_middle) const {
    return reckoning_.velocity_to(now, before_from_middle);
  }

  MotionState state() const;
  void restore(const MotionState& state);

 private:
  /// By odometry, since the scan before.
  bool has_stood_still(const MotionInput& now) const;
  /// Kalman update of the predicted move by the one found, which may be known less well: along a
  /// bare corridor velocities would be made of nothing but the errors of matches.
  Pose2 filtered(const MotionInput& now,
                 const Pose2& before_from_now,
                 const Eigen::Matrix3d& covariance) const;
  /// What each sensor says; nothing where it cannot tell.
  std::optional<MotionGuess> from_odometry(const MotionInput& now) const;
  std::optional<MotionGuess> from_gyro(const MotionInput& now) const;
  void judge_predictions(const MotionInput& now, const Pose2& before_from_now, double sigma_m);
  /// By the way since the step began, once that is a second ago.
  void judge_sensors(const MotionInput& now,
                     const Pose2& before_from_now,
                     bool matched,
                     double sigma_m);

  MotionOptions options_;
  MotionState state_;  ///< but for `reckoning`
  DeadReckoning reckoning_;
};

}  // namespace marco::slam
