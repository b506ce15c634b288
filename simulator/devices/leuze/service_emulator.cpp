#include "simulator/devices/leuze/service_emulator.hpp"

#include <algorithm>

namespace marco::drivers::leuze {

LeuzeServiceEmulator::LeuzeServiceEmulator(LaserWorld world, const LeuzeGeometry& geometry)
    : world_(std::move(world)), geometry_(geometry) {
  validate(geometry, "leuze_service_emulator");
}

void LeuzeServiceEmulator::on_connection(bool /*connected*/, Utime /*now*/) {
  asked_.clear();
  output_.clear();
}

void LeuzeServiceEmulator::receive(std::span<const uint8_t> bytes, int /*baud*/, Utime now) {
  asked_.insert(asked_.end(), bytes.begin(), bytes.end());
  const auto request = service_request();
  if (asked_.size() != request.size() ||
      !std::equal(asked_.begin(), asked_.end(), request.begin())) {
    return;
  }
  const int64_t sweep_us = Duration::from_seconds(kSweepS).us;
  last_first_beam_ = Utime::from_us((now.us / sweep_us - 1) * sweep_us);
  std::vector<float> ranges;
  for (const double range_m : world_(sweep_of(geometry_, last_first_beam_, kServiceStep))) {
    ranges.push_back(static_cast<float>(measured_m(range_m) / geometry_.scale));
  }
  output_.send(encode_service_answer(ranges), now);
  ++scans_sent_;
}

void LeuzeServiceEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  output_.advance(now, out);
}

Utime LeuzeServiceEmulator::next_event() const { return output_.next_event(); }

}  // namespace marco::drivers::leuze
