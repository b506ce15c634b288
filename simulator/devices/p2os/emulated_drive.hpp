#pragma once

#include <optional>

#include "drivers/base/speed_profile.hpp"
#include "drivers/p2os/codec.hpp"

namespace marco::drivers::p2os {

struct P2osEmulatorOptions {
  RobotName name{"MARCO", "Pioneer", "P2DX"};
  double track_m = 0.357;  ///< 2 / DiffConvFactor mm
  double cycle_s = 0.1;    ///< of the information packets
  double watchdog_s = 2.0;
  double max_velocity_m_per_s = 2.2;
  double default_velocity_m_per_s = 0.4;
  double default_acceleration_m_per_s2 = 0.3;
  double default_rate_deg_per_s = 50.0;
  double default_rate_acceleration_deg_per_s2 = 100.0;
  int bumpers_each_end = 5;  ///< 0 = none: then its packets show all of them pressed
  bool tells_config = true;  ///< old firmware does not
  int ticks_per_mm = 39;     ///< of the wheel encoders; ours
  int host_baud = 0;         ///< in its flash: 0 9600, 1 19200, 2 38400, 3 57600, 4 115200
};

/// The motion of an emulated Pioneer: its wheels follow orders, its own dead reckoning is exact.
class EmulatedDrive {
 public:
  explicit EmulatedDrive(const P2osEmulatorOptions& options);

  /// Power-on state; the travel of the wheels is kept.
  void reset();
  /// Commands of motion; others are ignored.
  void execute(const Command& command);
  /// The client has closed: motors off.
  void release();
  /// Ends the running order; the wheels brake. The watchdog does that.
  void brake();
  void step(double dt_s, bool blocked);

  double left_m() const { return left_m_; }  ///< signed travel of the wheels
  double right_m() const { return right_m_; }
  const Pose2& reckoned() const { return reckoned_; }
  bool motors_on() const { return motors_on_; }
  bool stalled() const { return stalled_; }
  const SpeedProfile& velocity() const { return velocity_; }
  const SpeedProfile& rate() const { return rate_; }

 private:
  void drop_goals();
  void set_wheel_velocities(int bytes);  ///< two int8 of 20 mm/s: left, right
  void halt();
  double to_heading() const;

  P2osEmulatorOptions options_;
  SpeedProfile velocity_;               ///< [m/s]
  SpeedProfile rate_;                   ///< [rad/s]
  std::optional<double> way_left_m_;    ///< of MOVE, signed
  std::optional<double> heading_goal_;  ///< of HEAD and DHEAD
  double left_m_ = 0.0;
  double right_m_ = 0.0;
  Pose2 reckoned_;  ///< since SETO
  bool motors_on_ = false;
  bool stalled_ = false;  ///< the motors have given up until the next order
};

}  // namespace marco::drivers::p2os
