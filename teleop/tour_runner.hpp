#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "simulator/tour.hpp"

namespace marco::teleop {

struct TourOptions {
  double longest_move_m = 1.0;       ///< then the heading is corrected anew
  double arrive_m = 0.12;            ///< near enough to a point
  double turn_first_deg = 3.0;       ///< off by more: turns before it moves
  double sweep_max_deg_per_s = 5.5;  ///< up to which the pan-tilt tells its angles well
  double scans_per_s = 37.5;         ///< until the laser's own rate is known
  double settle_s = 0.3;             ///< before and after a sweep
  double pose_patience_s = 3.0;      ///< for a pose newer than the last move
  double link_patience_s = 3.0;      ///< without a word from base or pan-tilt
  int retries = 3;                   ///< before an obstacle, 2 s apart

  template <class Visitor>
  void visit(Visitor& v) {
    v("longest_move_m", longest_move_m, kPositive);
    v("arrive_m", arrive_m, kPositive);
    v("turn_first_deg", turn_first_deg, kPositive);
    v("sweep_max_deg_per_s", sweep_max_deg_per_s, kPositive);
    v("scans_per_s", scans_per_s, kPositive);
    v("settle_s", settle_s, kNotNegative);
    v("pose_patience_s", pose_patience_s, kPositive);
    v("link_patience_s", link_patience_s, kPositive);
    v("retries", retries, Limits{0, 100});
  }
};

/// Drives a tour (config/tours/*.toml) by orders to base and pan-tilt, step by step, each when the
/// one before is done. It has no clock and no network: told what comes, it says what to send.
class TourRunner {
 public:
  enum class Outcome { running, done, blocked, lost };

  /// @throws std::invalid_argument naming the step that makes no sense.
  TourRunner(const sim::Tour& tour, const TourOptions& options);

  void on_pose(const Pose2& world_from_robot, Utime measured) {
    pose_ = {measured, world_from_robot};
  }
  void on_base_status(const BaseStatus& status, Utime now);
  void on_pantilt(const PanTiltState& state, Utime now);
  void on_scan(Utime now);

  struct Orders {
    std::vector<BaseCommand> base;
    std::vector<PanTiltCommand> pantilt;
  };
  /// Call some ten times a second or more often.
  Orders step(Utime now);
  /// What stops everything.
  Orders stop(Utime now);

  Outcome outcome() const { return outcome_; }
  double progress() const;  ///< 0..1
  /// "go 5.6 2.2 (3 of 15)", or why it ended.
  std::string state() const;

 private:
  enum class Phase {
    next,
    measure,
    turning,
    moving,
    blocked,
    panning,
    settling,
    sweeping,
    settled,
    homing,
    waiting
  };
  struct StampedPose {
    Utime utime;
    Pose2 world_from_robot;
  };

  const sim::TourStep& current() const { return tour_.steps[step_]; }
  void enter(Phase phase, Utime now);
  void begin_step(Utime now);
  void end_step(Utime now);
  void aim(Orders& orders, Utime now);
  void next_pan(Orders& orders, Utime now);
  void look(Orders& orders, double pan_deg, double tilt_deg, double rate_deg_per_s, Utime now);
  void order_base(Orders& orders, BaseCommand command, Utime now);
  std::optional<BaseStatus::Command> base_fate() const;
  bool looked() const;
  bool links_alive(Utime now);
  void fail(Outcome outcome, const std::string& why);

  sim::Tour tour_;
  TourOptions options_;
  Outcome outcome_ = Outcome::running;
  std::string why_;
  std::size_t step_ = 0;
  std::size_t pan_ = 0;
  int tries_ = 0;
  Phase phase_ = Phase::next;
  Utime phase_since_;
  std::optional<StampedPose> pose_;
  std::optional<BaseStatus> base_;
  std::optional<PanTiltState> head_;
  Utime base_heard_, head_heard_, began_;
  bool needs_head_ = false;
  int64_t id_ = 0;
  PanTiltCommand gaze_;
  Utime gaze_since_;
  Utime last_scan_;
  double scan_period_s_ = 0.0;
};

}  // namespace marco::teleop
