#pragma once

#include <cmath>
#include <cstdint>

namespace marco::drivers {

/// A wheel of an emulated base: its speed follows the order with a lag of first order.
struct LaggingWheel {
  double goal_m_per_s = 0.0;
  double speed_m_per_s = 0.0;
  double travelled_m = 0.0;     ///< signed, since it was made
  double counted_from_m = 0.0;  ///< where its counter was 0

  void step(double dt_s, double lag_s) {
    speed_m_per_s -= std::expm1(-dt_s / lag_s) * (goal_m_per_s - speed_m_per_s);
    if (goal_m_per_s == 0.0 && std::abs(speed_m_per_s) < 1e-3) speed_m_per_s = 0.0;
    travelled_m += speed_m_per_s * dt_s;
  }
  /// Its counter begins at 0 again.
  void reset_counter() { counted_from_m = travelled_m; }
  /// What its counter shows, wrapped to 16 bits.
  uint16_t ticks(double tick_m) const {
    return static_cast<uint16_t>(
        static_cast<int64_t>(std::floor((travelled_m - counted_from_m) / tick_m)));
  }
};

}  // namespace marco::drivers
