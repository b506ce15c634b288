#include "common/input/beam_times.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/input/input_gates.hpp"
#include "common/pose2.hpp"

namespace marco {
namespace {

// Lasers that spin may be covered in part; those that do not see 270 degrees at most (Hokuyo,
// SICK).
constexpr double kAllRoundDeg = 300.0;

using input_gates::kFastestS;
using input_gates::kSlowestS;
// The period between scans may be longer than a turn, where some are missing; it is shorter only by
// the jitter of stamps.
constexpr double kMostPart = 1.2;

struct Unit {
  double factor;
  const char* what;
};
constexpr std::array kUnits{Unit{1e3, "beam times 1000 times too short: rescaled"},
                            Unit{1e6, "beam times 1000000 times too short: rescaled"},
                            Unit{1e-3, "beam times 1000 times too long: rescaled"},
                            Unit{1e-6, "beam times 1000000 times too long: rescaled"}};

double coverage_rad(const LaserScan& scan) {
  if (scan.bearings_rad.empty()) {
    return std::abs(scan.bearing_step_rad) * static_cast<double>(scan.size());
  }
  // Bearings may run over the half turn.
  double sum = 0.0;
  for (std::size_t beam = 1; beam < scan.size(); ++beam) {
    sum += normalize_angle(scan.bearing_rad(beam) - scan.bearing_rad(beam - 1));
  }
  return std::abs(sum);
}

bool is_one_turn(double span_s, double period_s) {
  return span_s >= kFastestS && span_s <= std::min(kSlowestS, kMostPart * period_s);
}

}  // namespace

bool is_turn_period(double period_s) { return period_s >= kFastestS && period_s <= kSlowestS; }

bool sees_all_round(const LaserScan& scan) {
  return coverage_rad(scan) >= deg_to_rad(kAllRoundDeg);
}

std::optional<BeamSpan> span_of_turn(const LaserScan& scan, double period_s) {
  if (scan.time_offsets_s.size() < 2) return std::nullopt;
  const auto [first, last] =
      std::minmax_element(scan.time_offsets_s.begin(), scan.time_offsets_s.end());
  const double span_s = static_cast<double>(*last) - static_cast<double>(*first);
  if (!is_one_turn(span_s, period_s)) return std::nullopt;
  return BeamSpan{*first, *last};
}

std::optional<std::string> repair_beam_times(LaserScan& scan, double period_s) {
  if (!(period_s > 0.0) || scan.time_offsets_s.size() < 2) return std::nullopt;
  if (!sees_all_round(scan) || span_of_turn(scan, period_s)) return std::nullopt;
  const auto [first, last] =
      std::minmax_element(scan.time_offsets_s.begin(), scan.time_offsets_s.end());
  const double span_s = static_cast<double>(*last) - static_cast<double>(*first);
  for (const Unit& unit : kUnits) {
    if (!is_one_turn(unit.factor * span_s, period_s)) continue;
    for (float& offset_s : scan.time_offsets_s) {
      offset_s = static_cast<float>(unit.factor * static_cast<double>(offset_s));
    }
    return unit.what;
  }
  return std::nullopt;
}

}  // namespace marco
