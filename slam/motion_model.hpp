#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "common/options.hpp"
#include "common/pose2.hpp"
#include "common/utime.hpp"
#include "slam/scan_preparation.hpp"

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

/// What the robot's own sensors say at a scan's time.
struct MotionInput {
  Utime utime;
  std::optional<Pose2> odom_from_robot;
  std::optional<double> gyro_heading_rad;  ///< integrated yaw rate, from any start
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
  };
  std::optional<MotionInput> before;
  std::deque<Step> history;
  double period_s = 0.0;      ///< of the scans: a running median
  double before_lag_s = 0.0;  ///< of the scan before
  double move_m = 0.0;        ///< of late, from one scan to the next
  double turn_rad = 0.0;
};

/// Remembers the last scan's odometry and the last estimated velocity. Not thread-safe.
class MotionModel {
 public:
  explicit MotionModel(const MotionOptions& options = {});

  /// The move from the scan before to this one. Changes nothing.
  MotionGuess guess(const MotionInput& now) const;

  /// Takes note of this scan's input and of the move that was found.
  void update(const MotionInput& now, const Pose2& before_from_now);

  /// During the next scan, as far as known.
  Velocity2 velocity() const { return velocity_; }

  MotionState state() const {
    return {before_, history_, period_s_, before_lag_s_, move_m_, turn_rad_};
  }
  void restore(const MotionState& state);

 private:
  MotionGuess from_odometry(const Pose2& step) const;
  MotionGuess from_velocity(double dt_s) const;

  void measure_velocity();
  /// How far this scan's stamp lags behind the rhythm of the scans. A logger that stalls stamps
  /// several scans nearly alike; odometry looked up by such a stamp belongs to another moment.
  double lag_s(double dt_s) const;
  void learn_rhythm(double dt_s, const Pose2& step);

  using Step = MotionState::Step;
  MotionOptions options_;
  std::optional<MotionInput> before_;
  std::deque<Step> history_;
  Velocity2 velocity_;
  bool velocity_known_ = false;
  double period_s_ = 0.0;      ///< of the scans: a running median
  double before_lag_s_ = 0.0;  ///< lag_s of the scan before
  double move_m_ = 0.0;        ///< of late, from one scan to the next
  double turn_rad_ = 0.0;
};

}  // namespace marco::slam
