#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/rplidar/codec.hpp"
#include "drivers/rplidar/sample_clock.hpp"

namespace marco::drivers::rplidar {

/// Gathers the samples of each turn of the head into one scan of irregular bearings and times.
/// Drops an express capsule whose successor was lost: its angles are unknown.
class TurnAssembler {
 public:
  explicit TurnAssembler(int baud) : baud_(baud) {}

  /// @param sample_s  of the stream that starts now
  void start(double sample_s);
  /// @param arrival  of the block's last byte
  void add_node(const Block& block, Utime arrival);
  void add_capsule(const Block& block, Utime arrival);
  /// The count of samples is lost, and with it the turn and the capsule under way.
  void lose_count();

  std::vector<ArrivedScan> take_scans() { return std::exchange(ready_, {}); }
  double turn_s() const { return turn_s_; }
  LaserCounts& counts() { return counts_; }
  const LaserCounts& counts() const { return counts_; }
  const ClockFilter& filter() const { return clock_.filter(); }

 private:
  bool follows_directly(const Capsule& next);
  void note_arrival(Utime arrival);
  void add_sample(int64_t sample, double angle_deg, double range_m, bool new_turn);
  void finish_turn();

  int baud_;
  SampleClock clock_;
  Utime last_arrival_;
  std::optional<Capsule> capsule_;  ///< waits for its successor
  double usual_span_deg_ = 0.0;     ///< from a capsule to the next
  double last_angle_deg_ = 0.0;
  std::optional<LaserScan> turn_;  ///< under way; none before the first turn begins
  std::vector<int64_t> turn_samples_;
  double turn_s_ = 0.18;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

}  // namespace marco::drivers::rplidar
