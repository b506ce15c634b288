#pragma once

#include <functional>
#include <optional>

#include "drivers/base/click_odometry.hpp"
#include "drivers/hcs12/drive_run.hpp"
#include "drivers/hcs12/line_exchange.hpp"

namespace marco::drivers::hcs12 {

/// What the base's driver asks of its board to move the wheels and to follow them.
class BoardCommands {
 public:
  /// @param exchange outlives it.
  explicit BoardCommands(LineExchange& exchange) : exchange_(exchange) {}

  void status() { exchange_.ask({encode_command('l'), 'l'}); }
  void status_first() { exchange_.ask_first({encode_command('l'), 'l'}); }
  /// Drops what is queued.
  void stop();
  /// A ramp the board has already is not sent again.
  void ramp_if_new(const Ramp& ramp);
  void ramp(const Ramp& ramp);
  void run(const RunOrder& order);
  /// `w`: the board answers when the wheels rest, at the latest after the rest of the walk.
  void wait_for_rest(const RampWalk& walk, Utime now);

  bool waits() const { return wait_until_.has_value(); }
  void end_wait() { wait_until_.reset(); }
  /// When the answer of `w` was lost, or the board is: asks for the status instead.
  bool give_up_wait(Utime now);
  int64_t lost_waits() const { return lost_waits_; }

  /// Asks for the status when it is due and nothing else is on the line. @returns whether it did.
  bool poll(Utime now, double period_s);
  void poll_at(Utime when) { next_status_ = when; }

  /// Nothing is queued or awaited.
  bool quiet() const { return exchange_.quiet(); }
  char awaited() const { return exchange_.awaited(); }
  void clear_queue() { exchange_.clear_queue(); }

 private:
  LineExchange& exchange_;
  std::optional<Ramp> ramp_;  ///< as last sent
  std::optional<Utime> wait_until_;
  Utime next_status_;
  int64_t lost_waits_ = 0;
};

/// The motion of the base: runs one after the other, pieces of a leg or those of a velocity, and
/// the odometry of what they drive. The board drives straight or turns on the spot. A slow run is
/// followed by the counters; a fast one by the firmware's ramp, settled by the counters at its end.
class RunControl {
 public:
  using Publish = std::function<void(const OdometrySample&)>;

  /// @param options, exchange  outlive it.
  RunControl(const Hcs12BaseOptions& options, LineExchange& exchange, Publish publish);

  /// Sends a leg's first piece. @returns false when it is too short to drive.
  bool start_leg(const BaseDriver::Leg& leg, const BaseSpeeds& speeds, Utime now);
  /// Call at each step while the velocity is wanted.
  void drive(double velocity_m_per_s,
             double yaw_rate_rad_per_s,
             const BaseSpeeds& speeds,
             Utime now);
  /// What drive() makes of a velocity.
  BaseVelocity as_driven(const BaseVelocity& order, const BaseSpeeds& speeds) const;
  void stop();
  /// [m] or [rad], signed.
  double leg_remaining() const;

  enum class Event {
    none,
    stopped,
    leg_reached,
    leg_missed,
    implausible,  ///< the status cannot be true
    counters_restarted
  };
  Event on_wheel_status(const WheelStatus& status, Utime measured, Utime now);
  /// The board has echoed a command. @returns whether the wheels begin to turn by it.
  bool on_echo(char letter, Utime begun, Utime now);
  /// "w" came. @returns false when nothing waits for it.
  bool on_wait_answer(Utime begun);
  void on_timeout(const LineExchange::Request& request, Utime now);

  /// Call at each step, before any other. Notices when this process stood still.
  void note_time(Utime now);
  /// Publishes predictions of a fast run.
  void follow_ramp(Utime now);
  /// Asks what the run under way needs. @returns whether there is one.
  bool schedule(Utime now);
  bool under_way() const { return run_.has_value(); }

  /// The link is gone: forgets orders. What is driven from now on the counters will tell.
  void abandon();
  /// The counters are gone, too: the board was reset.
  void forget();
  /// The link is back: asks the counters what the lost run drove.
  void take_up_lost_run(Utime now);
  /// The host's clock may have been set back.
  void forget_stamps();
  bool has_lost_run() const { return lost_run_.has_value(); }

  BoardCommands& commands() { return commands_; }
  const ClickOdometry& odometry() const { return odometry_; }
  int64_t lost_waits() const { return commands_.lost_waits(); }

 private:
  void start(const RunOrder& order, Utime now);
  void renew(RunOrder next, Utime now);
  void take_over(Utime begun);
  Event on_run_over(Utime now);
  Event on_status_at_rest(bool still, Utime measured);
  double metres_per_s(double clicks_per_tick) const;

  const Hcs12BaseOptions& options_;
  BoardCommands commands_;
  ClickOdometry odometry_;
  Publish publish_;
  std::optional<DriveRun> run_;
  std::optional<DriveRun> renewal_;   ///< asked for: follows on run_ when the board has it
  std::optional<DriveRun> lost_run_;  ///< when the link went; the board counts on
  bool stop_asked_ = false;           ///< stop() waits for the counters
  double pace_ = 1.0;    ///< how fast the board really works off its ramp, learnt from fast moves
  int implausible_ = 0;  ///< status lines in a row
  Utime last_step_;
  Utime next_prediction_;
};

}  // namespace marco::drivers::hcs12
