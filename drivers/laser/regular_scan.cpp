#include "drivers/laser/regular_scan.hpp"

#include <cmath>
#include <limits>

namespace marco::drivers {

LaserScan regular_scan(const LaserScan& scan) {
  LaserScan regular;
  regular.utime = scan.utime;
  regular.channel = scan.channel;
  regular.first_bearing_rad = scan.size() > 0 ? scan.bearing_rad(0) : scan.first_bearing_rad;
  regular.bearing_step_rad = scan.bearing_step_rad;
  if (scan.bearings_rad.empty() || scan.size() < 2) {
    regular.ranges_m = scan.ranges_m;
    return regular;
  }
  std::vector<double> from_first_rad(scan.size(), 0.0);  // bearings do not wrap here
  for (std::size_t i = 1; i < scan.size(); ++i) {
    from_first_rad[i] =
        from_first_rad[i - 1] + normalize_angle(scan.bearing_rad(i) - scan.bearing_rad(i - 1));
  }
  const double step_rad = from_first_rad.back() / static_cast<double>(scan.size() - 1);
  regular.bearing_step_rad = step_rad;
  regular.ranges_m.assign(scan.size(), 0.0F);
  if (step_rad == 0.0) return regular;
  std::vector<double> off(scan.size(), std::numeric_limits<double>::infinity());  // steps
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double place = from_first_rad[i] / step_rad;
    const double nearest = std::round(place);
    if (nearest < 0.0 || nearest >= static_cast<double>(scan.size())) continue;
    const auto beam = static_cast<std::size_t>(nearest);
    if (std::abs(place - nearest) >= off[beam]) continue;
    off[beam] = std::abs(place - nearest);
    regular.ranges_m[beam] = scan.ranges_m[i];
  }
  return regular;
}

}  // namespace marco::drivers
