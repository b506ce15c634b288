#pragma once

#include <optional>
#include <vector>

#include "drivers/laser/turn_gatherer.hpp"
#include "drivers/rplidar/codec.hpp"

namespace marco::drivers::rplidar {

/// Gathers the samples of each turn of the head into one scan of irregular bearings and times.
/// Drops an express capsule whose successor was lost: its angles are unknown.
class TurnAssembler {
 public:
  /// Of the line; 0 = none.
  void set_baud(int baud) { baud_ = baud; }
  /// @param sample_s  of the stream that starts now
  void start(double sample_s);
  /// @param arrival  of the block's last byte
  void add_node(const Block& block, Utime arrival);
  void add_capsule(const Block& block, Utime arrival);
  /// The count of samples is lost, and with it the turn and the capsule under way.
  void lose_count();

  std::vector<ArrivedScan> take_scans() { return gatherer_.take_scans(); }
  double turn_s() const { return gatherer_.turn_s(); }
  LaserCounts& counts() { return counts_; }
  const LaserCounts& counts() const { return counts_; }
  const ClockFilter& filter() const { return clock_.filter(); }

 private:
  bool follows_directly(const Capsule& next);
  void note_arrival(Utime arrival);
  void add_sample(int64_t sample, double angle_deg, double range_m, bool new_turn);

  int baud_ = 0;
  SampleClock clock_;
  Utime last_arrival_;
  std::optional<Capsule> capsule_;  ///< waits for its successor
  double usual_span_deg_ = 0.0;     ///< from a capsule to the next
  double last_angle_deg_ = 0.0;
  TurnGatherer gatherer_{clock_};
  LaserCounts counts_;
};

}  // namespace marco::drivers::rplidar
