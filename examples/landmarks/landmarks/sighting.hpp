#pragma once

#include <vector>

#include "lcm_tools/base/utime.hpp"

namespace marco::slam {

/// One landmark seen by a sensor: which one it is, is not known.
struct Sighting {
  double range_m = 0.0;      ///< to its middle
  double bearing_rad = 0.0;  ///< from straight ahead of the sensor, counter-clockwise
  double diameter_m = 0.0;   ///< 0 = not measured
};

/// What one scan saw, possibly nothing.
struct SightingScan {
  Utime utime;
  std::vector<Sighting> sightings;
};

/// What the wheels say.
struct WheelVelocity {
  Utime utime;
  double speed_m_per_s = 0.0;
  double turn_rate_rad_per_s = 0.0;  ///< counter-clockwise
};

}  // namespace marco::slam
