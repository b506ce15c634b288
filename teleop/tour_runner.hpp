#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "simulator/tour.hpp"

namespace marco::teleop {

/// What a tour receives from base and pan-tilt, and whether they are still alive.
class TourLinks {
 public:
  void need_head() { needs_head_ = true; }
  void on_base(const BaseStatus& status, Utime now);
  void on_head(const PanTiltState& state, Utime now);

  /// Why the tour cannot continue; "" = no reason. Patience counts from the first call.
  std::string trouble(double patience_s, Utime now);
  /// Whether base and, if needed, pan-tilt take orders.
  bool ready() const;
  const std::optional<BaseStatus>& base() const { return base_; }
  const std::optional<PanTiltState>& head() const { return head_; }

 private:
  bool needs_head_ = false;
  std::optional<BaseStatus> base_;
  std::optional<PanTiltState> head_;
  Utime base_heard_;
  Utime head_heard_;
  Utime began_;
};

/// The scan rate of a laser, smoothed.
class ScanRate {
 public:
  void on_scan(Utime now);
  double scans_per_s(double until_known) const;

 private:
  Utime last_scan_;
  double period_s_ = 0.0;
};

struct TourOptions {
  double longest_move_m = 1.0;       ///< then the heading is corrected again
  double arrive_m = 0.12;            ///< a point counts as reached
  double turn_first_deg = 3.0;       ///< turns before a move when the heading is off by more
  double sweep_max_deg_per_s = 5.5;  ///< faster, the pan-tilt's angles are not accurate
  double scans_per_s = 37.5;         ///< until the laser's own rate is known
  double settle_s = 0.3;             ///< before and after a sweep
  double pose_patience_s = 3.0;      ///< for a pose newer than the last move
  double link_patience_s = 3.0;      ///< for a message from base or pan-tilt
  int retries = 3;                   ///< at an obstacle, 2 s apart

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

/// Drives a tour (config/tours/*.toml): sends orders to base and pan-tilt, each when the one before
/// is done. Without clock and network: it takes what was received and returns what to send.
class TourRunner {
 public:
  enum class Outcome { running, done, blocked, lost };

  /// @throws std::invalid_argument naming the invalid step.
  TourRunner(const sim::Tour& tour, const TourOptions& options);

  void on_pose(const Pose2& world_from_robot, Utime measured) {
    pose_ = {measured, world_from_robot};
  }
  void on_base_status(const BaseStatus& status, Utime now) { links_.on_base(status, now); }
  void on_pantilt(const PanTiltState& state, Utime now) { links_.on_head(state, now); }
  void on_scan(Utime now) { scan_rate_.on_scan(now); }

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

  struct Place {
    std::size_t step = 0;
    std::size_t pan = 0;  ///< of a sweep
    int tries = 0;        ///< before an obstacle
  };
  struct Gaze {
    PanTiltCommand command;
    Utime since;
  };

  const sim::TourStep& current() const { return tour_.steps[place_.step]; }
  void enter(Phase phase, Utime now);
  void begin_step(Utime now);
  void end_step(Utime now);
  void act(Orders& orders, Utime now);
  void aim(Orders& orders, Utime now);
  void watch_leg(double since_s, Utime now);
  void sweep(Orders& orders, Utime now);
  void next_pan(Orders& orders, Utime now);
  void look(Orders& orders, double pan_deg, double tilt_deg, double rate_deg_per_s, Utime now);
  void order_base(Orders& orders, BaseCommand command, Utime now);
  std::optional<BaseStatus::Command> base_fate() const;
  bool looked() const;
  void fail(Outcome outcome, const std::string& why);

  sim::Tour tour_;
  TourOptions options_;
  Outcome outcome_ = Outcome::running;
  std::string why_;
  Place place_;
  Phase phase_ = Phase::next;
  Utime phase_since_;
  std::optional<StampedPose> pose_;
  TourLinks links_;
  ScanRate scan_rate_;
  int64_t id_ = 0;
  Gaze gaze_;
};

}  // namespace marco::teleop
