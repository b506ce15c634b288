#include "drivers/hcs12/sonar_sequencer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace marco::drivers::hcs12 {

SonarSequencer::SonarSequencer(Range range_m, const Options& options)
    : range_m_(std::move(range_m)), options_(options) {}

// The shot that was in progress is kept, as on the board.
void SonarSequencer::restart() {
  order_.resize(16);
  std::iota(order_.begin(), order_.end(), 0U);
  readings_.fill(kNoEcho);
  on_ = false;
  listen_ms_ = 50;
  rest_ms_ = 20;
  rounds_ = shots_left_ = 0;
}

void SonarSequencer::set_order(const Command& command) {
  const std::size_t count = std::min<std::size_t>(command.count, 16);
  order_.assign(command.values.begin(),
                command.values.begin() + static_cast<std::ptrdiff_t>(count));
}

std::string SonarSequencer::execute(const Command& command) {
  if (command.count == 0) {
    std::vector<uint32_t> times;
    for (const uint32_t transducer : order_) times.push_back(readings_[transducer % 16]);
    shots_left_ = static_cast<int64_t>(order_.size()) + 1;
    return encode_sonar(times, options_.form);
  }
  if (command.values[0] > 2) return "s" + std::to_string(rounds_) + "\n";
  if (command.values[0] == 2) {
    listen_ms_ = command.values[1];
    rest_ms_ = command.values[2];
    return "s\n";
  }
  on_ = command.values[0] == 1;
  if (on_) {
    readings_.fill(kNoEcho);
    shot_ = shot_tick_ = 0;
    shots_left_ = static_cast<int64_t>(order_.size());
  }
  return "s\n";
}

void SonarSequencer::tick() {
  if (!on_ || order_.empty()) return;
  const uint32_t listened = 2 + listen_ms_;  // after the shot and the blanking
  ++shot_tick_;
  if (shot_tick_ == listened) take_reading();
  if (shot_tick_ < listened + rest_ms_ + 1) return;
  shot_tick_ = 0;
  if (++shot_ >= order_.size()) {
    shot_ = 0;
    ++rounds_;
  }
}

void SonarSequencer::take_reading() {
  const std::size_t transducer = order_[shot_ % order_.size()] % 16;
  const double range_m = range_m_ ? range_m_(transducer) : HUGE_VAL;
  const uint32_t units =
      std::isfinite(range_m) ? sonar_time_units(range_m, options_.speed_of_sound_m_per_s) : kNoEcho;
  const bool in_window = units * kSonarUnitUs <= static_cast<double>(listen_ms_ * kTickUs);
  readings_[transducer] = in_window ? units : kNoEcho;
  if (shots_left_ > 0) --shots_left_;
}

}  // namespace marco::drivers::hcs12
