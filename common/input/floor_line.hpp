#pragma once

#include <string>

#include "common/laser_scan.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco {

/// Where the beams of a laser that is not level reach the floor (or the ceiling): a straight line
/// across one bearing, which moves with the robot.
struct FloorLine {
  std::string channel;       ///< of the laser
  double bearing_deg = 0.0;  ///< the steepest beam's, in the laser's frame, from ahead
  double from_m = 0.0;       ///< distance of the line: beyond it returns are the floor's

  template <class Visitor>
  void visit(Visitor& v) {
    v("channel", channel);
    v("bearing_deg", bearing_deg, Limits{-360.0, 360.0});
    v("from_m", from_m, kPositive);
  }
  bool operator==(const FloorLine&) const = default;
};

/// Makes no returns of those on the line and beyond. @returns how many there were.
std::size_t blank(LaserScan& scan, const FloorLine& floor);

/// `LIDAR is not level: its beams under 0 deg reach the floor or the ceiling at 2.31 m`.
std::string describe(const FloorLine& floor);

}  // namespace marco
