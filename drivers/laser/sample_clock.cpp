#include "drivers/laser/sample_clock.hpp"

namespace marco::drivers {
namespace {

constexpr double kNoteEveryS = 0.015;

}  // namespace

void SampleClock::start(double sample_s) {
  filter_.reset();
  sample_s_ = sample_s;
  sample_ = noted_sample_ = 0;
  noted_s_ = -1.0;
}

void SampleClock::note_arrival(Utime arrival) {
  const double device_s = static_cast<double>(sample_) * sample_s_;
  if (device_s - noted_s_ < kNoteEveryS) return;
  noted_s_ = device_s;
  noted_utime_ = filter_.update(device_s, arrival);
  noted_sample_ = sample_;
}

void SampleClock::lose_count() {
  filter_.reset();
  noted_s_ = -1.0;
}

// Sample n is measured one period before the count n + 1 is reached.
Utime SampleClock::time_of(int64_t sample) const {
  return noted_utime_ +
         Duration::from_seconds(static_cast<double>(sample - noted_sample_) * host_sample_s());
}

}  // namespace marco::drivers
