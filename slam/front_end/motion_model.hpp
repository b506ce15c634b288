#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/input/synchronized_scan.hpp"
#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::slam {

/// Standard deviations of a move before its scan is matched. Odometry is weighted far below its
/// own accuracy: as a prior it must help where the scan is silent (a bare corridor) and give way
/// everywhere else.
struct MotionOptions {
  double sigma_per_m = 0.15;
  double sigma_deg_per_deg = 0.15;
  double gyro_sigma_deg_per_s = 0.3;
  /// Without odometry: how much the velocity may change.
  double acceleration_m_per_s2 = 1.5;
  double turn_acceleration_deg_per_s2 = 120.0;
  double max_speed_m_per_s = 3.0;  ///< of the robot: what claims more is not believed
  double max_turn_rate_deg_per_s = 400.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("sigma_per_m", sigma_per_m, kNotNegative);
    v("sigma_deg_per_deg", sigma_deg_per_deg, kNotNegative);
    v("gyro_sigma_deg_per_s", gyro_sigma_deg_per_s, kPositive);
    v("acceleration_m_per_s2", acceleration_m_per_s2, kPositive);
    v("turn_acceleration_deg_per_s2", turn_acceleration_deg_per_s2, kPositive);
    v("max_speed_m_per_s", max_speed_m_per_s, kPositive);
    v("max_turn_rate_deg_per_s", max_turn_rate_deg_per_s, kPositive);
  }
};

/// The velocity of a robot that moved by `moved` in `dt_s`; nothing when the time is too short to
/// tell, or the velocity is above the limits: the stamp or the odometry is wrong then.
std::optional<Velocity2> believed_velocity(const Pose2& moved,
                                           double dt_s,
                                           const MotionOptions& options);

/// A move since the scan before, in the robot's frame there.
struct MotionGuess {
  enum class Source { odometry, velocity, nothing };

  Pose2 before_from_now;
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Identity();  ///< of (x, y, theta) in the frame before
  Source source = Source::nothing;
};

/// What a MotionModel remembers.
struct MotionState {
  /// A scan of the last second, and the way from there to the newest.
  struct Step {
    Utime utime;
    Pose2 then_from_now;

    template <class Visitor>
    void visit(Visitor& v) {
      v("utime", utime);
      v("then_from_now", then_from_now);
    }
  };
  /// Fields that older saved maps hold; not used any more, they keep the format.
  struct Retired {
    double lag_s = 0.0;
    std::optional<MotionInput> input;
    Pose2 poses[2];
    int32_t counts[2] = {};
  };
  std::optional<MotionInput> before;
  std::deque<Step> history;
  double scan_period_s = 0.0;  ///< of the newest scan's laser
  double move_m = 0.0;         ///< from one scan to the next, a running mean
  double turn_rad = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    Retired retired;
    v("before", before);
    v("history", history);
    v("scan_period_s", scan_period_s);
    v("retired", retired.lag_s);
    v("move_m", move_m);
    v("turn_rad", turn_rad);
    v("retired", retired.input);
    v("retired", retired.poses[0]);
    v("retired", retired.counts[0]);
    v("retired", retired.poses[1]);
    v("retired", retired.counts[1]);
  }
};

/// Predicts each scan's move, by odometry where there is any, else by dead reckoning with the
/// velocity of the last scans. Stamps and odometry are those that SensorSynchronizer has repaired.
/// Not thread-safe.
class MotionModel {
 public:
  explicit MotionModel(const MotionOptions& options = {});

  /// The move from the scan before to this one. Changes nothing.
  MotionGuess guess(const MotionInput& now) const;

  /// Whether odometry says that the robot has not moved, and recent scans agree.
  bool stands_still(const MotionInput& now) const;

  /// The innovation gate: whether `moved`, between the scan before and `now`, exceeds the limits of
  /// MotionOptions by 0.3 m or 30 degrees.
  bool exceeds_motion_limits(const Pose2& moved, Utime now) const;
  /// The scan before's time; only after an update.
  Utime newest() const { return state_.before->utime; }

  /// Takes note of this scan's input and of the move that was found.
  void update(const MotionInput& now, const Pose2& before_from_now);

  /// To deskew the next scan by, smoothed over two scans at least.
  Velocity2 velocity() const { return smoothed_velocity_; }

  const MotionState& state() const { return state_; }
  void restore(const MotionState& state);

 private:
  MotionGuess from_odometry(const Pose2& step, double passed_s, double off_beat) const;
  MotionGuess from_velocity(double dt_s) const;
  void fuse_gyro(const MotionInput& now, MotionGuess& guess) const;
  void measure_velocity();
  std::optional<Velocity2> velocity_since(const MotionState::Step& step) const;

  MotionOptions options_;
  MotionState state_;
  std::optional<Velocity2> velocity_;
  Velocity2 smoothed_velocity_;
};

}  // namespace marco::slam
