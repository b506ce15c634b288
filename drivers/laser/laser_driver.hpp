#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/laser_scan.hpp"

namespace marco::drivers {

/// The time a driver lives in: wall_now, or a SimulatedLine's.
using Clock = std::function<Utime()>;

struct ArrivedScan {
  LaserScan scan;  ///< utime: of its first beam
  Utime arrival;   ///< of its last byte
};

/// What a laser sees, for SENSOR_INFO.
struct LaserSight {
  double scan_duration_s = 0.0;  ///< first beam to last beam
  double range_min_m = 0.0;
  double range_max_m = 0.0;  ///< at or beyond it there was no return
  double range_sigma_m = 0.0;
};

/// Good and bad of a laser's line since its opening.
struct LaserCounts {
  int64_t scans = 0;
  int64_t garbage_bytes = 0;             ///< outside any telegram
  std::map<std::string, int64_t> drops;  ///< telegrams not used, by cause ("bad_checksum")
};

/// A laser on an open line: made anew for each opening. One thread.
class LaserDriver {
 public:
  virtual ~LaserDriver() = default;

  /// Works for at most 100 ms: finds the device, sets it up, reads. Never blocks longer, whatever
  /// the device does. @returns the scans that became complete. @throws StreamLost.
  virtual std::vector<ArrivedScan> step() = 0;

  /// What waited in the line was read and thrown away by another: telegrams begun, and the count of
  /// turns, go with it. What step() returned last is to be thrown away, too.
  virtual void on_line_emptied() = 0;

  virtual std::string state() const = 0;
  /// Whether the laser answers: what it sends is understood.
  virtual bool answers() const = 0;
  virtual LaserSight sight() const = 0;
  virtual const LaserCounts& counts() const = 0;

  /// Ends the measuring in good order. @throws StreamLost.
  virtual void stop() {}
};

}  // namespace marco::drivers
