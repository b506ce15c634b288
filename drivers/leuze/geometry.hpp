#pragma once

#include <numbers>

#include "lcm_tools/base/options.hpp"

namespace marco::drivers::leuze {

inline constexpr int kLastIndex = 529;    ///< of a beam; the first is 1
inline constexpr int kMiddleIndex = 265;  ///< straight ahead
inline constexpr double kSweepS = 0.040;  ///< a turn of the mirror

/// The bearings of the beams, and the calibration of the ranges.
struct LeuzeGeometry {
  double beam_step_deg = 0.36;  ///< of neighbouring indices; thesis A's code has 190/528
  bool clockwise = true;        ///< index 1 is left (other drivers) or right (thesis A)
  double scale = 1.0;           ///< measured times this are metres; thesis A: 1.077

  template <class Visitor>
  void visit(Visitor& v) {
    v("beam_step_deg", beam_step_deg, Limits{0.1, 1.0});
    v("clockwise", clockwise);
    v("scale", scale, Limits{0.5, 2.0});
  }
  /// Counter-clockwise from ahead. @param index 1..529
  double bearing_rad(int index) const { return (index - kMiddleIndex) * step_rad(); }
  double step_rad() const {
    return (clockwise ? -beam_step_deg : beam_step_deg) * std::numbers::pi / 180.0;
  }
  double beam_interval_s() const { return kSweepS * beam_step_deg / 360.0; }
};

/// As thesis A's code has it: 133 beams, from the right.
inline LeuzeGeometry thesis_a_geometry() { return {190.0 / 528.0, false, 1.077}; }

}  // namespace marco::drivers::leuze
