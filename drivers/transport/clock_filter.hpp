#pragma once

#include <deque>

#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// Converts a device's clock to this host's. A reading arrives late: by the line's time at least,
/// by some jitter more. So the arrivals, plotted over device time, lie above a straight line. The
/// filter finds it as the edge of their lower convex hull below the middle of the last window
/// (Zhang, Liu and Xia, "Clock synchronization algorithms for network measurements", INFOCOM 2002).
/// Its slope is the drift; an arrival's height above it is that arrival's delay.
class ClockFilter {
 public:
  /// @param max_drift  bound of the drift that is believed, e.g. 0.01
  explicit ClockFilter(double max_drift = 0.01, std::size_t window = 400)
      : max_drift_(max_drift), window_(window) {}

  /// @param device_s  device time, never decreasing; any origin.
  /// @param arrival   on this host, known delays (line time) taken off.
  /// @returns the host's time when the device's clock showed device_s; never after `arrival`.
  Utime update(double device_s, Utime arrival);

  /// Device seconds per host second, less one; 0 until there are enough readings.
  double drift() const { return slope_ > 0.0 ? 1.0 / slope_ - 1.0 : 0.0; }
  /// Standard deviation and maximum of the delays removed, over the window.
  double jitter_s() const;
  double max_delay_s() const;

  /// The device's clock was restarted.
  void reset();

 private:
  struct Reading {
    double device_s;
    double arrival_s;  ///< after origin_
    double delay_s = 0.0;
  };
  void fit();

  double max_drift_;
  std::size_t window_;
  std::deque<Reading> readings_;
  Utime origin_;
  double slope_ = 1.0;     ///< host seconds per device second
  double anchor_s_ = 0.0;  ///< a point on the line, after origin_
  double anchor_device_s_ = 0.0;
};

}  // namespace marco::drivers
