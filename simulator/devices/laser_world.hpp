#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// One turn of an emulated laser's mirror: the beams whose ranges it asks for.
struct LaserSweep {
  Utime first_beam;                ///< when beam 0 is measured
  double beam_interval_s = 0.0;    ///< from a beam to the next
  double first_bearing_rad = 0.0;  ///< sensor frame, counter-clockwise from ahead
  double bearing_step_rad = 0.0;   ///< negative for a clockwise sweep
  int beams = 0;
};

/// @returns one range a beam [m]: infinity = nothing came back, NaN = the laser was dazzled. Called
/// after the sweep: first_beam lies up to some 0.1 s in the past, never in the future.
using LaserWorld = std::function<std::vector<double>(const LaserSweep&)>;

}  // namespace marco::drivers
