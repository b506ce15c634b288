#pragma once

#include <optional>

namespace marco::drivers {

/// A speed, along or about, that follows its goal by a trapezoid.
struct SpeedProfile {
  double limit = 0.0;
  double acceleration = 0.0;
  double deceleration = 0.0;
  double speed = 0.0;
  double goal = 0.0;

  /// @param left  distance to a goal; as fast as can still be braked.
  void step(std::optional<double> left, double dt_s);
  /// A negative acceleration sets the deceleration.
  void set_acceleration(double value);
};

}  // namespace marco::drivers
