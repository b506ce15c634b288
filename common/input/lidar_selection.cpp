#include "common/input/lidar_selection.hpp"

#include <cmath>
#include <cstring>

namespace marco {
namespace {

// Five scans of the slowest laser, 5 Hz.
constexpr double kRawEndedS = 1.0;
// Both messages of one scan carry its stamp, perhaps rounded to milliseconds.
constexpr double kSameScanS = 0.002;

double apart_s(Utime a, Utime b) { return std::abs((a - b).seconds()); }

}  // namespace

bool LidarSelection::is_used(const LaserScan& scan) {
  const std::string lidar = lidar_of_(scan.channel);
  Laser& laser = lasers_[lidar];
  if (lidar != scan.channel) {
    laser.has_raw = true;
    laser.newest_raw = scan.utime;
    return !laser.has_planar || apart_s(scan.utime, laser.newest_planar) > kSameScanS;
  }
  if (laser.has_raw && apart_s(scan.utime, laser.newest_raw) <= kRawEndedS) return false;
  laser.has_planar = true;
  laser.newest_planar = scan.utime;
  return true;
}

bool LidarSelection::came_before(const LaserScan& scan) {
  LaserScan& last = last_[scan.channel];
  // By its bits: a beam without a return may be NaN.
  const bool same = scan.utime == last.utime && !scan.ranges_m.empty() &&
                    scan.ranges_m.size() == last.ranges_m.size() &&
                    std::memcmp(scan.ranges_m.data(), last.ranges_m.data(),
                                scan.ranges_m.size() * sizeof(float)) == 0;
  if (!same) last = scan;
  return same;
}

}  // namespace marco
