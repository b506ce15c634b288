#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// One turn of an emulated laser's mirror, as it asks the world for its ranges.
struct LaserSweep {
  Utime first_beam;                ///< when beam 0 is measured
  double beam_interval_s = 0.0;    ///< from a beam to the next
  double first_bearing_rad = 0.0;  ///< sensor frame, counter-clockwise from ahead
  double bearing_step_rad = 0.0;   ///< negative for a clockwise sweep
  int beams = 0;
};

/// Answers with one range a beam [m]: infinity = nothing came back, NaN = the laser was dazzled. It
/// is asked after the sweep, so that a simulator must know some 0.1 s of its past (a first_beam may
/// lie that far back, never in the future).
using LaserWorld = std::function<std::vector<double>(const LaserSweep&)>;

}  // namespace marco::drivers
