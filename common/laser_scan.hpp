#pragma once

#include <string>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco {

/// Ranges from here on are no returns, whatever SENSOR_INFO says: no mapping laser sees so far.
inline constexpr double kFarthestReturnM = 300.0;

/// One sweep of a planar laser, as measured: nothing filtered, nothing moved.
struct LaserScan {
  Utime utime;                        ///< of the first beam
  std::string channel = "LIDAR";      ///< which laser
  std::vector<float> ranges_m;        ///< may hold 0, NaN, infinite or over-range values: no return
  double first_bearing_rad = 0.0;     ///< sensor frame, counter-clockwise from ahead
  double bearing_step_rad = 0.0;      ///< negative for a clockwise sweep
  std::vector<float> bearings_rad;    ///< empty, or one per beam (then first and step are unused)
  std::vector<float> time_offsets_s;  ///< empty, or one per beam: time after `utime`

  std::size_t size() const { return ranges_m.size(); }
  double bearing_rad(std::size_t beam) const {
    return bearings_rad.empty() ? first_bearing_rad + static_cast<double>(beam) * bearing_step_rad
                                : static_cast<double>(bearings_rad[beam]);
  }
};

}  // namespace marco
