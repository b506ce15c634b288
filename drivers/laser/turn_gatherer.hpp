#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/clock_filter.hpp"

namespace marco::drivers {

/// Time stamps of samples. The laser takes them at a fixed period, so their number is its clock.
/// One thread.
class SampleClock {
 public:
  /// @param max_drift  how far the true period may be off, as a part of it
  explicit SampleClock(double max_drift = 0.02) : filter_(max_drift) {}

  /// A scan starts: the next sample is number 0.
  void start(double sample_s);
  /// Counts a sample. @returns its number.
  int64_t count() { return sample_++; }
  /// Counts samples that were taken and are lost.
  void skip(int64_t samples) { sample_ += samples; }
  /// @param arrival  when the sample counted last left the laser
  void note_arrival(Utime arrival);
  /// Samples were lost, nobody knows how many.
  void lose_count();

  /// Samples are timed from the arrival noted last.
  Utime time_of(int64_t sample) const;
  /// A sample's period in seconds of this host.
  double host_sample_s() const { return sample_s_ / (1.0 + filter_.drift()); }
  double sample_s() const { return sample_s_; }
  const ClockFilter& filter() const { return filter_; }

 private:
  ClockFilter filter_;
  double sample_s_ = 0.0;
  int64_t sample_ = 0;     ///< number of the next
  double noted_s_ = -1.0;  ///< device time of the last arrival given to the filter
  int64_t noted_sample_ = 0;
  Utime noted_utime_;
};

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
