#pragma once

#include <numbers>

#include "drivers/base/base_driver.hpp"

namespace marco::drivers::hcs12 {

/// Geometry that the thesis leaves open is ours: wheels of 30 cm, 50 cm apart.
struct Hcs12BaseOptions {
  double clicks_per_wheel_turn = 65500.0;  ///< 1000 clicks, gear 65.5:1
  double wheel_diameter_m = 0.30;          ///< ours
  double track_m = 0.50;                   ///< ours
  /// Clicks a tick up to which the counters may be read in motion: printing `l` takes 26 ticks, in
  /// which an eight-bit counter must not overflow. Faster moves are read at their end.
  double poll_limit_clicks = 9.0;
  double poll_period_s = 0.1;
  double velocity_limit_m_per_s = 0.13;  ///< in velocity mode, which must be read in motion
  bool sonar = true;
  double sonar_ring_radius_m = 0.25;  ///< ours
  double sonar_cone_deg = 15.0;
  double speed_of_sound_m_per_s = 343.0;
  BaseSpeeds speeds;
  /// The emulated board stops at once, within 0.11 s of the order, and takes another speed within
  /// 0.3 s: it does not brake, but 2 m/s2 is as sure as a wheel's grip.
  GuardOptions guard{.braking_m_per_s2 = 2.0, .delay_s = 0.3};

  double metres_per_click() const {
    return std::numbers::pi * wheel_diameter_m / clicks_per_wheel_turn;
  }

  template <class Visitor>
  void visit(Visitor& v) {
    v("clicks_per_wheel_turn", clicks_per_wheel_turn, kPositive);
    v("wheel_diameter_m", wheel_diameter_m, kPositive);
    v("track_m", track_m, kPositive);
    v("poll_limit_clicks", poll_limit_clicks, Limits{1.0, 90.0});
    v("poll_period_s", poll_period_s, Limits{0.05, 10.0});
    v("velocity_limit_m_per_s", velocity_limit_m_per_s, kPositive);
    v("sonar", sonar);
    v("sonar_ring_radius_m", sonar_ring_radius_m, kNotNegative);
    v("sonar_cone_deg", sonar_cone_deg, kPositive);
    v("speed_of_sound_m_per_s", speed_of_sound_m_per_s, kPositive);
    v("speeds", speeds);
    v("guard", guard);
  }
};

}  // namespace marco::drivers::hcs12
