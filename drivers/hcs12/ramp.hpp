#pragma once

#include <cstdint>

namespace marco::drivers::hcs12 {

/// The firmware's speed ramp.
struct Ramp {
  uint32_t start = 5;        ///< clicks a tick
  uint32_t top = 30;         ///< clicks a tick
  uint32_t step_ticks = 50;  ///< the speed changes by one click a tick every step_ticks + 1 ticks
  bool operator==(const Ramp&) const = default;
};

/// The acceleration control of both boards: the ordered speed rises until the wheel is near the top
/// speed, and falls once the brake point is passed. The brake point mirrors the acceleration: half
/// the distance at first, corrected when the top speed is reached.
class RampControl {
 public:
  void start(int64_t target_clicks);
  /// One tick. @returns the change of the ordered speed: 1, -1 or 0.
  int step(int64_t wheel_speed, int64_t clicks);
  /// Begins to brake when the brake point is passed.
  void brake_if_due(int64_t clicks);

  int64_t target_clicks() const { return target_clicks_; }

  Ramp ramp;  ///< may change while it runs, as on the boards

 private:
  enum class Phase { cruising, accelerating, braking };
  Phase phase_ = Phase::cruising;
  int64_t target_clicks_ = 0;
  int64_t brake_point_ = 0;
  uint32_t timer_ = 0;
};

/// Predicts tick by tick where a wheel should be between two readings. The firmware's controller
/// ignores errors of one click a tick (integer division), so a real wheel stays that much behind
/// its order; an ideal one follows it exactly.
class RampWalk {
 public:
  enum class Brake { to_zero, to_start };  ///< the base's and the pan-tilt's
  enum class Wheel { ideal, real };

  RampWalk() = default;
  RampWalk(const Ramp& ramp, uint32_t target_clicks, Brake brake, Wheel wheel = Wheel::ideal);

  void tick();
  /// Ticks on until `ticks` have passed in all, or to the end.
  void advance_to(int64_t ticks);
  void finish() { advance_to(INT64_MAX); }
  bool done() const { return done_; }
  int64_t clicks() const { return clicks_; }
  int64_t speed() const { return done_ ? 0 : wheel_speed_; }  ///< clicks a tick
  int64_t ticks() const { return ticks_; }

 private:
  RampControl control_;
  int64_t dead_zone_ = 0;
  int64_t floor_ = 0;
  int64_t speed_ = 0;  ///< ordered
  int64_t wheel_speed_ = 0;
  bool done_ = true;
  int64_t clicks_ = 0;
  int64_t ticks_ = 0;
};

}  // namespace marco::drivers::hcs12
