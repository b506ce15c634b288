#pragma once

#include <cstdint>

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

}  // namespace marco::drivers
