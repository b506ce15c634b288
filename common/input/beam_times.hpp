#pragma once

#include <optional>
#include <string>

#include "common/laser_scan.hpp"

namespace marco {

/// Whether a laser may turn once in this time: 0.02 to 0.35 s.
bool is_turn_period(double period_s);
/// From 300 degrees on.
bool sees_all_round(const LaserScan& scan);

struct BeamSpan {
  float first_s, last_s;
};
/// The times of a scan's earliest and latest beam, where they are as far apart as a laser's turn
/// takes, and not much more than `period_s`, the time between scans.
std::optional<BeamSpan> span_of_turn(const LaserScan& scan, double period_s);

/// Repairs beam times in a wrong unit, as in recordings that have milliseconds added to
/// microseconds. The beams of a laser that turns all the way round follow each other through one
/// turn, of 0.02 to 0.35 s: times that span so much after rescaling by a power of 1000 are
/// rescaled. All others are left as they are, and those of lasers that see less than 300 degrees.
/// @param scan  whose time_offsets_s may be changed
/// @param period_s  between scans; 0 = not known yet, and nothing is changed
/// @returns what was wrong and what was done, for a person.
std::optional<std::string> repair_beam_times(LaserScan& scan, double period_s);

}  // namespace marco
