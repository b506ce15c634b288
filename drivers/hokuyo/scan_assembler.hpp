#pragma once

#include <utility>
#include <vector>

#include "drivers/hokuyo/codec.hpp"
#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/clock_filter.hpp"

namespace marco::drivers::hokuyo {

/// Turns measurements into scans with the time of every beam. The stamps come from the laser's own
/// clock (24 bits of milliseconds). Ranges that are error codes become 0.
class ScanAssembler {
 public:
  /// A stream of scans starts. @param cluster  steps merged to one beam. @param skip  turns left
  /// out between two scans
  void start(const Parameters& parameters, int cluster, int skip);
  /// The laser has answered the request of a stream: its clock may have been reset.
  void restart_clock();

  /// Takes a scan, or counts why not.
  /// @param end  when its reply began to leave the laser: arrival less line time
  void add(const Reply& reply, Utime end, Utime arrival);

  const ScanRequest& request() const { return request_; }
  const Parameters& parameters() const { return parameters_; }
  double scan_duration_s() const;
  double scan_period_s() const { return turn_s() * (1 + request_.skip); }

  std::vector<ArrivedScan> take_scans() { return std::exchange(ready_, {}); }
  LaserCounts& counts() { return counts_; }
  const LaserCounts& counts() const { return counts_; }
  const ClockFilter& filter() const { return filter_; }

 private:
  double turn_s() const { return 60.0 / parameters_.rpm; }
  double step_s() const { return turn_s() / parameters_.steps_per_turn; }
  double from_rear_s(int step) const;
  LaserScan scan_of(const Measurement& measured, Utime rear) const;

  Parameters parameters_;
  ScanRequest request_;
  ClockFilter filter_{0.001};
  int64_t device_ms_ = 0;  ///< unwrapped; 0 before the first scan
  uint32_t last_stamp_ms_ = 0;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

}  // namespace marco::drivers::hokuyo
