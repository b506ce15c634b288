#pragma once

#include "driven_base.hpp"
#include "drivers/textbase/driver.hpp"

namespace marco::drivers::textbase {

/// A small robot: 7050 ticks a metre.
inline TextBaseOptions small_robot() {
  TextBaseOptions options;
  options.ticks_per_turn = 1440.0;
  options.wheel_diameter_m = 0.065;
  options.track_m = 0.16;
  return options;
}

inline double ticks_per_m(const TextBaseOptions& options) {
  return options.ticks_per_turn / (std::numbers::pi * options.wheel_diameter_m);
}

}  // namespace marco::drivers::textbase
