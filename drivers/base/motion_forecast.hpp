#pragma once

#include <cmath>
#include <deque>

#include "common/footprint.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// A base's velocity in its own frame: an arc.
struct BaseVelocity {
  double ahead_m_per_s = 0.0;
  double turn_rad_per_s = 0.0;  ///< counter-clockwise

  bool is_zero() const { return ahead_m_per_s == 0.0 && turn_rad_per_s == 0.0; }
  /// At least that of the fastest point within `radius_m`.
  double fastest_m_per_s(double radius_m) const {
    return std::abs(ahead_m_per_s) + std::abs(turn_rad_per_s) * radius_m;
  }
  BaseVelocity operator*(double part) const {
    return {part * ahead_m_per_s, part * turn_rad_per_s};
  }
  bool operator==(const BaseVelocity&) const = default;
};

/// How fast a base's speeds follow an order.
struct BaseDynamics {
  double acceleration_m_per_s2 = 0.0;
  double braking_m_per_s2 = 0.0;
  double turn_acceleration_rad_per_s2 = 0.0;
  double turn_braking_rad_per_s2 = 0.0;
};

/// Foresees where a base goes: by the velocity that is measured, the orders that have been sent
/// and take effect later, and its dynamics.
class MotionForecast {
 public:
  /// @param delay_s  from an order to the wheels.
  explicit MotionForecast(double delay_s) : delay_s_(delay_s) {}

  void set_dynamics(const BaseDynamics& dynamics) { dynamics_ = dynamics; }
  /// Velocities of a few ticks are coarse: they correct what the orders lead one to expect.
  /// @param since_s  the one before.
  void on_measured(const BaseVelocity& velocity, double since_s, Utime now);
  void on_sent(const BaseVelocity& order, Utime now);
  void on_rest() { sent_.clear(); }
  const BaseVelocity& measured() const { return measured_; }

  /// The way, by steps of a centimetre of the body's fastest point, when `order` is sent for
  /// `order_s` and then a stop. @returns the start alone for a base that rests; no more than 6 m.
  Sweep stopping_way(const BaseVelocity& order, double order_s, Utime now, double radius_m) const;

 private:
  struct Sent {
    Utime when;
    BaseVelocity order;
  };
  BaseVelocity in_effect(Utime now) const;
  BaseVelocity after(const BaseVelocity& speed, const BaseVelocity& goal, double seconds) const;

  double delay_s_;
  BaseDynamics dynamics_;
  BaseVelocity measured_;
  std::deque<Sent> sent_;  ///< changes; the first is in effect
};

}  // namespace marco::drivers
