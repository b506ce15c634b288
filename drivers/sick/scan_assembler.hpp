#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/laser/scan_clock.hpp"
#include "drivers/sick/options.hpp"

namespace marco::drivers::sick {

/// Turns value telegrams into scans with the time of every beam. A scan of 0.5 or 0.25 degrees is
/// interlaced: two or four turns of the mirror measure whole degrees each, one shifted against the
/// other, so that neighbouring beams lie a turn apart in time.
class ScanAssembler {
 public:
  /// @throws std::invalid_argument for options that the laser does not have.
  explicit ScanAssembler(const SickOptions& options);

  /// Takes a telegram of measured values, or counts why not.
  /// @param arrival  of its last byte
  void add(const Event& event, Utime arrival, int baud);
  void restart_clock() { clock_.reset(); }

  std::vector<ArrivedScan> take_scans() { return std::exchange(ready_, {}); }
  LaserProperties properties() const;
  LaserCounts& counts() { return counts_; }
  const LaserCounts& counts() const { return counts_; }
  double period_s() const { return options_.scan_period_s(); }
  const ClockFilter& filter() const { return clock_.filter(); }

 private:
  const char* reason_to_drop(const Event& event, const std::optional<MeasuredValues>& values) const;
  LaserScan scan_of(const MeasuredValues& values, Utime first_beam) const;

  SickOptions options_;
  RangeRule rule_;
  ScanClock clock_;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

}  // namespace marco::drivers::sick
