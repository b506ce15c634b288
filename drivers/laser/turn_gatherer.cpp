#include "drivers/laser/turn_gatherer.hpp"

#include "common/pose2.hpp"

namespace marco::drivers {
namespace {

constexpr double kNoteEveryS = 0.015;

constexpr std::size_t kMaxSamples = 20'000;

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

bool TurnGatherer::begin_turn(Utime arrival) {
  const std::optional<Turn> whole = std::exchange(turn_, Turn{});
  if (!whole || whole->numbers.size() < 2) return false;
  ArrivedScan scan{whole->scan, arrival, whole->intensities};
  const int64_t first = whole->numbers.front();
  scan.scan.utime = clock_.time_of(first);
  const double sample_s = clock_.host_sample_s();
  for (const int64_t number : whole->numbers) {
    scan.scan.time_offsets_s.push_back(
        static_cast<float>(static_cast<double>(number - first) * sample_s));
  }
  turn_s_ = static_cast<double>(scan.scan.time_offsets_s.back());
  ready_.push_back(std::move(scan));
  return true;
}

void TurnGatherer::add(const Sample& sample) {
  if (!turn_ || turn_->numbers.size() >= kMaxSamples) return;
  turn_->scan.ranges_m.push_back(static_cast<float>(sample.range_m));
  turn_->scan.bearings_rad.push_back(static_cast<float>(normalize_angle(sample.bearing_rad)));
  turn_->intensities.push_back(static_cast<float>(sample.intensity));
  turn_->numbers.push_back(sample.number);
}

}  // namespace marco::drivers
