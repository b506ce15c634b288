#pragma once

#include <deque>
#include <optional>

#include "lcm_tools/base/utime.hpp"
#include "slam/front_end/motion_guess.hpp"

namespace marco::slam {

/// What DeadReckoning remembers.
struct DeadReckoningState {
  /// A scan of the last second, and the way from its middle to that of the newest.
  struct Step {
    Utime utime;
    Pose2 then_from_now;

    template <class Visitor>
    void visit(Visitor& v) {
      v("utime", utime);
      v("then_from_now", then_from_now);
    }
  };
  std::optional<Utime> newest;
  std::deque<Step> history;
  double scan_period_s = 0.0;  ///< of the newest scan's laser; 0 = not known
  Pose2 last_step;             ///< to the newest scan's middle from that of the one before
  Pose2 newest_from_middle;    ///< from the newest scan's first beam, see deskew.hpp
  /// Running mean of log(squared error by time / squared error by scans): above 0 where stamps are
  /// so irregular that scans are the better clock.
  double clock_contest = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("newest", newest);
    v("history", history);
    v("scan_period_s", scan_period_s);
    v("last_step", last_step);
    v("newest_from_middle", newest_from_middle);
    v("clock_contest", clock_contest);
  }
};

/// Dead reckoning: the move to the next scan by those before. Either the velocity of the last scans
/// lasts for the time that has passed, or the last step is made again, whatever the stamps say: a
/// logger that stalls stamps scans of a steady laser a millisecond and half a second apart. Which
/// of both, the moves found so far decide.
///
/// Velocities are measured from the middle of a scan to the middle of the next. From first beam to
/// first beam they would feed back: the pose there errs with the velocity that the scan was
/// deskewed by. Not thread-safe.
class DeadReckoning {
 public:
  explicit DeadReckoning(const MotionOptions& options) : options_(options) {}

  /// The move from the newest scan to one at `now`; `nothing`, and where the robot may be by then,
  /// before the second scan and after a gap. @param now_from_middle  see deskew.hpp
  MotionGuess guess(Utime now, const Pose2& now_from_middle = {}) const;
  /// Takes note of a move. @param matched  it was found by a scan: it judges the guesses
  void update(Utime now,
              double scan_period_s,
              const Pose2& before_from_now,
              bool matched,
              const Pose2& now_from_middle = {});

  /// That leads from the newest scan's middle to `before_from_middle`, of a scan at `now`; nothing
  /// if that is invalid.
  std::optional<Velocity2> velocity_to(Utime now, const Pose2& before_from_middle) const;

  /// Of the last scans; nothing if their stamps are invalid.
  std::optional<Velocity2> velocity() const { return velocity_; }
  /// The same over two scans at least.
  Velocity2 smoothed_velocity() const { return smoothed_velocity_; }

  const DeadReckoningState& state() const { return state_; }
  void restore(const DeadReckoningState& state);

 private:
  /// From middle to middle.
  MotionGuess by_time(Utime now) const;
  MotionGuess by_scans() const;
  bool scans_are_the_clock(Utime now) const;
  void judge_clocks(Utime now, const Pose2& step);
  void measure_velocity();

  MotionOptions options_;
  DeadReckoningState state_;
  std::optional<Velocity2> velocity_;
  Velocity2 smoothed_velocity_;
};

}  // namespace marco::slam
