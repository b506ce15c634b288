#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/laser/sample_clock.hpp"

namespace marco::drivers {

/// Gathers the samples of a rotating head: each whole turn becomes a scan of irregular bearings and
/// times. One thread.
class TurnGatherer {
 public:
  struct Sample {
    int64_t number = 0;        ///< by the clock
    double bearing_rad = 0.0;  ///< sensor frame, counter-clockwise from ahead; any turn
    double range_m = 0.0;      ///< 0 = no return
    double intensity = 0.0;    ///< device units; 0 = not measured
  };

  /// @param clock  of the samples; outlives the gatherer.
  explicit TurnGatherer(const SampleClock& clock) : clock_(clock) {}
  TurnGatherer(const TurnGatherer&) = delete;
  TurnGatherer& operator=(const TurnGatherer&) = delete;

  /// A new turn begins; the one before is whole unless its beginning was not seen.
  /// @param arrival  of the last byte. @returns whether a scan became ready.
  bool begin_turn(Utime arrival);
  /// Ignored before the first turn begins, and beyond any laser's count.
  void add(const Sample& sample);
  /// Drops the turn under way. The next scan is that of the next whole turn.
  void drop_turn() { turn_.reset(); }

  std::vector<ArrivedScan> take_scans() { return std::exchange(ready_, {}); }
  /// Of the last whole turn, first sample to last [s].
  double turn_s() const { return turn_s_; }

 private:
  struct Turn {
    LaserScan scan;
    std::vector<float> intensities;
    std::vector<int64_t> numbers;
  };

  const SampleClock& clock_;
  std::optional<Turn> turn_;
  double turn_s_ = 0.18;
  std::vector<ArrivedScan> ready_;
};

}  // namespace marco::drivers
