#include "common/input/floor_line.hpp"

#include <cmath>

#include "lcm_tools/base/format.hpp"

namespace marco {

std::size_t blank(LaserScan& scan, const FloorLine& floor) {
  std::size_t blanked = 0;
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    const double ahead = std::cos(scan.bearing_rad(beam) - deg_to_rad(floor.bearing_deg));
    if (static_cast<double>(scan.ranges_m[beam]) * ahead < floor.from_m) continue;
    scan.ranges_m[beam] = 0.0F;
    ++blanked;
  }
  return blanked;
}

std::string describe(const FloorLine& floor) {
  return floor.channel +
         format(" is not level: its beams under %.0f deg reach the floor or the ceiling at %.2f m",
                floor.bearing_deg, floor.from_m);
}

}  // namespace marco
