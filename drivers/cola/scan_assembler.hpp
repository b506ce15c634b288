#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/cola/codec.hpp"
#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/clock_filter.hpp"

namespace marco::drivers::cola {

/// Turns LMDscandata into scans with the time of every beam, by the laser's own microseconds.
class ScanAssembler {
 public:
  /// The laser was asked for a stream: its clock may have been reset.
  void restart_clock();

  /// Takes a scan, or counts why not.
  void add(const ScanData& data, Utime arrival);

  /// Of the last scan, first beam to last [s].
  double scan_duration_s() const { return scan_duration_s_; }
  double scan_period_s() const { return scan_period_s_; }
  /// "" while it is fine.
  const char* trouble() const;

  std::vector<ArrivedScan> take_scans() { return std::exchange(ready_, {}); }
  LaserCounts& counts() { return counts_; }
  const LaserCounts& counts() const { return counts_; }
  const ClockFilter& filter() const { return filter_; }

 private:
  double unwrapped_s(uint32_t sent_us);

  ClockFilter filter_{0.001};
  std::optional<uint32_t> sent_us_;  ///< of the last scan
  double device_s_ = 0.0;            ///< the same without wrapping
  double scan_duration_s_ = 0.05;
  double scan_period_s_ = 1.0 / 15.0;
  uint32_t status_ = 0;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

}  // namespace marco::drivers::cola
