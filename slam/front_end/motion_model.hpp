#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"
#include "lcm_tools/base/utime.hpp"
#include "slam/input/deskew.hpp"

namespace marco::slam {

/// Standard deviations of what is known about a move before the scan is looked at. Odometry is
/// taken for much worse than it says: a prior must help where the scan is silent (a bare corridor)
/// and give way everywhere else.
struct MotionOptions {
  double sigma_floor_m = 0.01;
  double sigma_per_m = 0.15;
  double sigma_floor_deg = 0.5;
  double sigma_deg_per_m = 2.0;
  double sigma_deg_per_deg = 0.15;
  double gyro_sigma_deg_per_s = 0.3;
  double max_step_m = 8.0;  ///< odometry that claims more between two scans is not believed
  /// Without odometry: how much the velocity may change.
  double acceleration_m_per_s2 = 1.5;
  double turn_acceleration_deg_per_s2 = 120.0;
  double max_gap_s = 1.0;  ///< beyond it the last velocity says nothing
  /// Stamps of a bursty logger make nonsense of a velocity over one scan period: it is measured
  /// over at least this long, and not believed above the limits.
  double velocity_span_s = 0.15;
  double max_speed_m_per_s = 3.0;
  double max_turn_rate_deg_per_s = 400.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("sigma_floor_m", sigma_floor_m, kPositive);
    v("sigma_per_m", sigma_per_m, kNotNegative);
    v("sigma_floor_deg", sigma_floor_deg, kPositive);
    v("sigma_deg_per_m", sigma_deg_per_m, kNotNegative);
    v("sigma_deg_per_deg", sigma_deg_per_deg, kNotNegative);
    v("gyro_sigma_deg_per_s", gyro_sigma_deg_per_s, kPositive);
    v("max_step_m", max_step_m, kPositive);
    v("acceleration_m_per_s2", acceleration_m_per_s2, kPositive);
    v("turn_acceleration_deg_per_s2", turn_acceleration_deg_per_s2, kPositive);
    v("max_gap_s", max_gap_s, kPositive);
    v("velocity_span_s", velocity_span_s, kPositive);
    v("max_speed_m_per_s", max_speed_m_per_s, kPositive);
    v("max_turn_rate_deg_per_s", max_turn_rate_deg_per_s, kPositive);
  }
};

/// The velocity of a robot that moved so in `dt_s`; nothing when that is too short a time to tell,
/// or faster than options allow: a stamp, or odometry that started anew, is wrong then.
std::optional<Velocity2> believed_velocity(const Pose2& moved,
                                           double dt_s,
                                           const MotionOptions& options);

/// What the robot's own sensors say at a scan's time.
struct MotionInput {
  Utime utime;
  std::optional<Pose2> odom_from_robot;
  std::optional<double> gyro_heading_rad;  ///< integrated yaw rate, from any start

  template <class Visitor>
  void visit(Visitor& v) {
    v("utime", utime);
    v("odom_from_robot", odom_from_robot);
    v("gyro_heading_rad", gyro_heading_rad);
  }
};

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
  /// Scans since `velocity_span_s` ago, and the way from each to the newest.
  struct Step {
    Utime utime;
    Pose2 then_from_now;

    template <class Visitor>
    void visit(Visitor& v) {
      v("utime", utime);
      v("then_from_now", then_from_now);
    }
  };
  std::optional<MotionInput> before;
  std::deque<Step> history;
  double period_s = 0.0;      ///< of the scans: a running median
  double before_lag_s = 0.0;  ///< of the scan before
  double move_m = 0.0;        ///< of late, from one scan to the next
  double turn_rad = 0.0;
  /// The last scan whose stamp kept the rhythm, the way from there to the newest, and how many
  /// lagging ones lie between.
  std::optional<MotionInput> anchor;
  Pose2 anchor_from_before;
  int32_t lagging = 0;
  Pose2 last_step;  ///< a scan's, by odometry between the last two that kept the rhythm
  /// Scans whose odometry went with them whatever their stamp said, less those where it did not.
  int32_t came_with_scan = 0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("before", before);
    v("history", history);
    v("period_s", period_s);
    v("before_lag_s", before_lag_s);
    v("move_m", move_m);
    v("turn_rad", turn_rad);
    v("anchor", anchor);
    v("anchor_from_before", anchor_from_before);
    v("lagging", lagging);
    v("last_step", last_step);
    v("came_with_scan", came_with_scan);
  }
};

/// Remembers the last scan's odometry and the last estimated velocity. Not thread-safe.
///
/// Where a logger stalls, several scans get stamps nearly alike. Odometry that came with each scan
/// does not mind; odometry looked up by such a stamp belongs to another moment: the step from one
/// scan to the next is then far too short, and the one that catches up far too long. Which it is,
/// the scans that lag tell. If looked up, such a scan is predicted by the steps before, and the
/// first that keeps the rhythm again by all that odometry says since the last one that did.
class MotionModel {
 public:
  explicit MotionModel(const MotionOptions& options = {});

  /// The move from the scan before to this one. Changes nothing.
  MotionGuess guess(const MotionInput& now) const;

  /// Whether odometry says, and the scans of late do not deny, that the robot has not moved.
  bool stands_still(const MotionInput& now) const;

  /// Whether no robot moves so between the scan before and `now`: by 0.3 m or 30 degrees more
  /// than the limits of MotionOptions allow.
  bool leaps(const Pose2& moved, Utime now) const;
  /// The scan before's time; only after an update.
  Utime newest() const { return before_->utime; }

  /// Takes note of this scan's input and of the move that was found.
  void update(const MotionInput& now, const Pose2& before_from_now);

  /// During the next scan, as far as known, to straighten it by: over two scans at least.
  Velocity2 velocity() const { return calm_velocity_; }

  MotionState state() const {
    return {before_,  history_,   period_s_,      before_lag_s_,
            move_m_,  turn_rad_,  anchor_,        anchor_from_before_,
            lagging_, last_step_, came_with_scan_};
  }
  void restore(const MotionState& state);

 private:
  MotionGuess from_odometry(const Pose2& step) const;
  MotionGuess from_last_step() const;
  /// @param step  by odometry, of a scan `dt_s` after the one before by its stamp
  bool came_with_scan(const Pose2& step, double dt_s, bool lagging) const;
  void learn_step(const MotionInput& now);
  void learn_origin(const Pose2& step, const Pose2& matched, double dt_s);
  void doubt_stamp(const Pose2& step, double dt_s, MotionGuess& guess) const;
  /// Of odometry that leaps as no robot can the last velocity knows as much.
  void doubt_leap(double dt_s, MotionGuess& guess) const;
  void heed_gyro(const MotionInput& now, MotionGuess& guess) const;
  MotionGuess from_velocity(double dt_s) const;

  void measure_velocity();
  /// Since that step; nothing when it is not to be believed.
  std::optional<Velocity2> velocity_over(const MotionState::Step& step) const;
  /// How far this scan's stamp lags behind the rhythm of the scans.
  double lag_s(double dt_s) const;
  bool lags(double dt_s) const;
  /// Part of a scan period that the stamps say has gone by, -1 .. 1.
  double pace(double dt_s) const;
  void learn_rhythm(double dt_s, const Pose2& step);

  using Step = MotionState::Step;
  MotionOptions options_;
  std::optional<MotionInput> before_;
  std::deque<Step> history_;
  Velocity2 velocity_, calm_velocity_;
  bool velocity_known_ = false;
  double period_s_ = 0.0;      ///< of the scans: a running median
  double before_lag_s_ = 0.0;  ///< lag_s of the scan before
  double move_m_ = 0.0;        ///< of late, from one scan to the next
  double turn_rad_ = 0.0;
  std::optional<MotionInput> anchor_;
  Pose2 anchor_from_before_;
  int32_t lagging_ = 0;
  Pose2 last_step_;
  int32_t came_with_scan_ = 0;
};

}  // namespace marco::slam
