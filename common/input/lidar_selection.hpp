#pragma once

#include <map>
#include <string>
#include <string_view>

#include "common/laser_scan.hpp"

namespace marco {

/// Of a laser whose scans come on two channels, as LIDAR and with beam times as LIDAR_RAW, the raw
/// ones are used, and each scan once. Planar ones are used until the first raw one comes, and again
/// when none has come for a second of message time. It also detects scans that repeat the last one,
/// as in logs of two recorders that were merged. Not thread-safe.
class LidarSelection {
 public:
  /// LIDAR_FRONT for LIDAR_RAW_FRONT; any other channel's own name.
  using LidarOf = std::string (*)(std::string_view channel);

  explicit LidarSelection(LidarOf lidar_of) : lidar_of_(lidar_of) {}

  /// Whether a scan is used that follows all those that were asked about before.
  bool is_used(const LaserScan& scan);
  /// Whether a scan repeats the last one on its channel: same stamp, same ranges.
  bool came_before(const LaserScan& scan);
  void clear() {
    lasers_.clear();
    last_.clear();
  }

 private:
  struct Laser {
    bool has_raw = false;
    Utime newest_raw;
    bool has_planar = false;
    Utime newest_planar;  ///< that was used
  };
  LidarOf lidar_of_;
  std::map<std::string, Laser> lasers_;
  std::map<std::string, LaserScan> last_;  ///< by channel
};

}  // namespace marco
