#include "recordings/scan_bounds.hpp"

#include <cmath>
#include <numbers>

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco {

void require_scan(const LaserScan& scan) {
  constexpr double kMostTurnedRad = 3.0 * 2.0 * std::numbers::pi;  // beams may be interleaved
  require(scan.size() >= 2, "scan of fewer than 2 beams");
  require(scan.size() <= files::kMaxBeams, "scan of more than 100000 beams");
  require(
      !scan.bearings_rad.empty() ||
          std::abs(scan.bearing_step_rad) * static_cast<double>(scan.size() - 1) <= kMostTurnedRad,
      "scan whose beams go round three times");
}

}  // namespace marco
