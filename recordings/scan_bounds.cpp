#include "recordings/scan_bounds.hpp"

#include <cmath>
#include <numbers>

#include "common/files/text_fields.hpp"
#include "common/pose2.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco {
namespace {

// By all its beams, whichever way each goes on from the one before.
double turned_rad(const LaserScan& scan) {
  if (scan.bearings_rad.empty()) {
    return std::abs(scan.bearing_step_rad) * static_cast<double>(scan.size() - 1);
  }
  double turned = 0.0;
  for (std::size_t beam = 1; beam < scan.size(); ++beam) {
    turned += std::abs(normalize_angle(scan.bearing_rad(beam) - scan.bearing_rad(beam - 1)));
  }
  return turned;
}

}  // namespace

void require_scan(const LaserScan& scan) {
  constexpr double kMostTurnedRad = 3.0 * 2.0 * std::numbers::pi;  // beams may be interleaved
  require(scan.size() >= 2, "scan of fewer than 2 beams");
  require(scan.size() <= files::kMaxBeams, "scan of more than 100000 beams");
  require(turned_rad(scan) <= kMostTurnedRad, "scan whose beams go round three times");
}

}  // namespace marco
