#pragma once

#include <cmath>

namespace marco::drivers {

/// When a laser with a turning mirror measures a beam [s after the first beam of its scan].
/// @param turns  turns of the mirror that make up a scan: they interlace, beam after beam
/// @param turn_s  of one turn
inline double beam_time_s(int beam, double step_deg, int turns, double turn_s) {
  return (beam % turns + beam * std::abs(step_deg) / 360.0) * turn_s;
}

}  // namespace marco::drivers
