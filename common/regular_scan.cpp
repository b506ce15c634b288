#include "common/regular_scan.hpp"

#include <cmath>
#include <limits>

namespace marco {

LaserScan make_regular(const LaserScan& scan, float no_return_m) {
  if (scan.bearings_rad.empty()) return scan;
  double step_deg = 0.25;
  while (step_deg < 2.0 && 360.0 / step_deg > 1.25 * static_cast<double>(scan.size())) {
    step_deg *= 2.0;
  }
  const auto count = static_cast<std::size_t>(360.0 / step_deg);
  LaserScan regular;
  regular.utime = scan.utime;
  regular.channel = scan.channel;
  regular.first_bearing_rad = deg_to_rad(-180.0);
  regular.bearing_step_rad = deg_to_rad(step_deg);
  regular.ranges_m.assign(count, no_return_m);
  std::vector<double> misses(count, std::numeric_limits<double>::infinity());
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    const double place = (normalize_angle(scan.bearing_rad(beam)) - regular.first_bearing_rad) /
                         regular.bearing_step_rad;
    const double nearest = std::floor(place + 0.5);
    // Of damaged bytes a bearing may be no number, or too large to be brought into one turn.
    if (!(nearest >= 0.0 && nearest <= static_cast<double>(count))) continue;
    const std::size_t bin = static_cast<std::size_t>(nearest) % count;
    const double miss = std::abs(place - nearest);
    const float range_m = scan.ranges_m[beam];
    if (miss >= misses[bin]) continue;
    misses[bin] = miss;
    const bool returned = range_m > 0.0F && range_m < no_return_m;
    regular.ranges_m[bin] = returned ? range_m : no_return_m;
  }
  return regular;
}

}  // namespace marco
