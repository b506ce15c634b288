#pragma once

#include "drivers/transport/clock_filter.hpp"
#include "drivers/transport/turn_counter.hpp"

namespace marco::drivers {

/// Time stamps for a laser whose telegrams carry no time. The turns of its mirror are its clock.
class ScanClock {
 public:
  explicit ScanClock(double scan_period_s) : turns_(scan_period_s) {}

  /// @param end  of the scan by its arrival, line time taken off
  /// @param dropped  telegrams lost since the line was opened: if it grew, scans may be missing
  /// @returns the end of the scan with the delays removed.
  Utime update(Utime end, int64_t dropped);
  void reset();

  const ClockFilter& filter() const { return filter_; }

 private:
  TurnCounter turns_;
  ClockFilter filter_;
  int64_t dropped_before_ = 0;
};

}  // namespace marco::drivers
