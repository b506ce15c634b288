#pragma once

#include "drivers/laser/laser_driver.hpp"
#include "drivers/leuze/geometry.hpp"

namespace marco::drivers::leuze {

struct LeuzeOptions {
  static constexpr const char* kName = "leuze";
  static constexpr const char* kDefaultDevice = "/dev/ttyUSB0";  ///< TCP: native 9008, service 8000

  int baud = 57'600;     ///< 4800..115200; 0 = TCP
  bool service = false;  ///< thesis A's socket service instead of the laser itself
  double poll_s = 0.4;   ///< of the service: time from a scan to the next
  LeuzeGeometry geometry;
  double range_min_m = 0.1;
  double range_max_m = 64.0;
  double range_sigma_m = 0.02;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{0, 115'200});
    v("service", service);
    v("poll_s", poll_s, kNotNegative);
    v("geometry", geometry);
    v("range_min_m", range_min_m, kNotNegative);
    v("range_max_m", range_max_m, kPositive);
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }

  LaserProperties properties() const {
    return {(kLastIndex - 1) * geometry.beam_interval_s(), range_min_m, range_max_m, range_sigma_m};
  }

  /// A scan from its ranges before calibration. @param first  index of its first beam, 1..529
  template <class Ranges>
  LaserScan scan_of(const Ranges& ranges_m, int first, int step, Utime utime) const {
    LaserScan scan;
    scan.utime = utime;
    scan.first_bearing_rad = geometry.bearing_rad(first);
    scan.bearing_step_rad = step * geometry.step_rad();
    const double beam_s = step * geometry.beam_interval_s();
    for (const auto range_m : ranges_m) {
      scan.time_offsets_s.push_back(static_cast<float>(beam_s * static_cast<double>(scan.size())));
      scan.ranges_m.push_back(static_cast<float>(static_cast<double>(range_m) * geometry.scale));
    }
    return scan;
  }
};

}  // namespace marco::drivers::leuze
