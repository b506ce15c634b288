#pragma once

#include <optional>
#include <string>

#include "common/laser_scan.hpp"

namespace marco {

/// Repairs beam times in a wrong unit, as in recordings that have milliseconds added to
/// microseconds. The beams of a laser that turns all the way round follow each other through one
/// turn, of 0.02 to 0.35 s: times that span so much after rescaling by a power of 1000 are
/// rescaled. All others are left as they are, and those of lasers that see less than 300 degrees.
/// @param scan  whose time_offsets_s may be changed
/// @param period_s  between scans; 0 = not known yet, and nothing is changed
/// @returns what was wrong and what was done, for a person.
std::optional<std::string> repair_beam_times(LaserScan& scan, double period_s);

}  // namespace marco
