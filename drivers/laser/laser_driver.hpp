#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/laser_scan.hpp"

namespace marco::drivers {

/// The clock of a driver: wall_now, or that of a SimulatedLine.
using Clock = std::function<Utime()>;

/// A scan with the time of every beam, and when it came.
struct ArrivedScan {
  LaserScan scan;                       ///< utime: of its first beam; time_offsets_s: one a beam
  Utime arrival;                        ///< of its last byte
  std::vector<float> intensities = {};  ///< one a beam, device units; or empty
};

/// What a laser can see, for SENSOR_INFO.
struct LaserProperties {
  double scan_duration_s = 0.0;  ///< first beam to last beam
  double range_min_m = 0.0;
  double range_max_m = 0.0;  ///< a range from here on is no return
  double range_sigma_m = 0.0;
};

/// Telegrams used and dropped since the line was opened.
struct LaserCounts {
  int64_t scans = 0;
  int64_t garbage_bytes = 0;             ///< outside any telegram
  std::map<std::string, int64_t> drops;  ///< telegrams not used, by cause ("bad_checksum")

  int64_t dropped() const {
    int64_t sum = 0;
    for (const auto& [cause, count] : drops) sum += count;
    return sum;
  }
};

/// A laser on an open line. Constructed at each opening. One thread.
class LaserDriver {
 public:
  virtual ~LaserDriver() = default;

  /// Finds the device, sets it up, reads it. Returns within 100 ms, whatever the device does.
  /// @returns the scans that became complete. @throws StreamLost.
  virtual std::vector<ArrivedScan> step() = 0;

  /// The caller has read and discarded the input that had queued up. Drops telegrams received in
  /// part and restarts the time stamps. The caller discards what step() returned last.
  virtual void on_input_flushed() = 0;

  virtual std::string state() const = 0;
  /// Whether the laser answers: its telegrams are understood.
  virtual bool answers() const = 0;
  virtual LaserProperties properties() const = 0;
  virtual const LaserCounts& counts() const = 0;

  /// Ends the measurement in an orderly way. @throws StreamLost.
  virtual void stop() {}
};

}  // namespace marco::drivers
