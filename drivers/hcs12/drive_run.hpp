#pragma once

#include <optional>

#include "drivers/hcs12/base_options.hpp"
#include "drivers/hcs12/codec.hpp"
#include "drivers/hcs12/ramp.hpp"

namespace marco::drivers::hcs12 {

/// The board knows no deadline and no watchdog: once started, it drives to the end of its run. So
/// no run is long, and the wheels turn no longer than this after the process or the line has died.
inline constexpr double kVelocityRunS = 1.0;
inline constexpr double kLegRunS = 5.0;
inline constexpr uint32_t kMaxClicksPerTick = 90;  ///< what a wheel can do

/// One command a, r, i or d as it is sent.
struct RunOrder {
  char letter = 'a';
  uint32_t tenths = 0;         ///< distance of each wheel in hundreds of clicks
  uint32_t tenths_behind = 0;  ///< of the leg, for the runs that follow this one
  Ramp ramp;
  bool of_velocity = false;  ///< its end is not the end of a leg

  /// The first piece of a leg. tenths = 0: too short to drive.
  static RunOrder of_leg(const BaseDriver::Leg& leg,
                         const BaseSpeeds& speeds,
                         const Hcs12BaseOptions& options);
  /// A velocity, of which the larger part is driven; nothing when that is next to none.
  static std::optional<RunOrder> of_velocity_command(double velocity_m_per_s,
                                                     double yaw_rate_rad_per_s,
                                                     const BaseSpeeds& speeds,
                                                     const Hcs12BaseOptions& options);
  /// Whether the speed is so different that it is worth a run of its own: the firmware cannot
  /// change the speed of a run.
  bool differs_in_speed(const RunOrder& driven) const;
};

/// A run from its sending to the counters' last word.
class DriveRun {
 public:
  DriveRun(const RunOrder& order, double poll_limit_clicks, Utime now);

  /// The wheels turn since `when`.
  void begin(Utime when, Utime now);
  /// Whether the wheels can have done that. There is no checksum.
  bool is_plausible(const WheelStatus& status, Utime measured) const;
  struct Clicks {
    double left = 0.0, right = 0.0;  ///< signed
  };
  /// @returns the clicks since the last reading.
  Clicks read(const WheelStatus& status, Utime measured, Utime now);
  /// Clicks and speeds [clicks/s] since the last reading, expected at `when` from the speed then.
  Clicks extrapolated(Utime when) const;
  Clicks clicks_per_s() const;
  /// Clicks since the last reading, expected from the ramp.
  Clicks walked() const;

  double remaining_clicks() const;
  int64_t missing_clicks() const;
  bool moves(Utime now) const;
  /// What is left after the wheels stopped before their goal (the brake has no floor).
  RunOrder rest() const;
  /// The next piece of a long leg; what this one drove too far is taken off.
  RunOrder next_piece() const;
  /// How fast the board followed its ramp; nothing if that is unknown.
  std::optional<double> pace() const;

  RunOrder order;
  WheelSigns signs;
  bool polled = true;  ///< slow enough for its counters to be read in motion
  bool started = false;
  RampWalk walk;  ///< where it should be by now
  Utime started_at;
  Utime rested_at;  ///< by the answer of `w`
  int retries = 0;
  bool stood_still = false;  ///< this process did: what it read then was sent earlier

  struct Reading {
    uint32_t left_clicks = 0;
    uint32_t right_clicks = 0;
    Utime at;
    double left_clicks_per_s = 0.0;  ///< between the last two readings
    double right_clicks_per_s = 0.0;
    Utime progress_at;  ///< when the counters last grew
  };
  Reading reading;
};

}  // namespace marco::drivers::hcs12
