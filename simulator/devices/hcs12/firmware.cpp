#include "simulator/devices/hcs12/firmware.hpp"

#include <algorithm>
#include <cmath>

namespace marco::drivers::hcs12 {

void Motor::turn() {
  if (!on) {
    speed = 0.0;
    return;
  }
  const double wanted = direction * (model.ideal ? desired : model.gain * pwm);
  const double follow = model.ideal ? 1.0 : 1.0 - std::exp(-1.0 / model.time_constant_ticks);
  speed += follow * (wanted - speed);
  position += speed;
  travel += std::abs(speed);
}

void Motor::read_counter() {
  constexpr int64_t kAccumulatorMax = 255;
  const auto passed = static_cast<int64_t>(std::floor(travel + 1e-9)) - counted;
  counted += passed;
  speed_read = static_cast<int>(std::min(passed, kAccumulatorMax));
}

void Motor::start(int new_direction, int new_desired) {
  on = true;
  pwm = 0;
  direction = new_direction;
  desired = new_desired;
}

void Motor::stop(int idle_pwm) {
  on = false;
  pwm = idle_pwm;
  speed = 0.0;
}

void WaitCommand::arm(const Command& command, std::size_t conditions) {
  armed_ = true;
  ticks_ = command.values[0];
  flags_.assign(conditions, false);
  for (std::size_t i = 0; i < conditions && command.count == conditions + 1; ++i) {
    flags_[i] = command.values[i + 1] != 0;
  }
}

bool WaitCommand::over(const std::vector<bool>& conditions) const {
  if (!armed_ || ticks_ <= 0) return armed_;
  bool looked_at = false;
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    if (flags_[i] && !conditions[i]) return false;
    looked_at = looked_at || flags_[i];
  }
  return looked_at;
}

void FirmwareBoard::start(Utime now) {
  started_ = true;
  time_ = now;
  next_tick_ = now + Duration::from_us(kTickUs);
  printing_until_ = now;
  wait_.clear();
  restart();
}

void FirmwareBoard::reset(Utime now) {
  if (started_) run_until(now);
  sent_.clear();
  cutter_.clear();
  pending_.reset();
  start(now);
}

void FirmwareBoard::on_connection(bool connected, Utime now) {
  if (!started_) start(now);
  connected_ = connected;
  cutter_.clear();
}

void FirmwareBoard::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  if (!started_) start(now);
  run_until(now);
  readable_ = baud == 0 || baud == kBaud;
  if (!readable_) return;  // noise at another speed
  for (const uint8_t byte : bytes) {
    const auto line = cutter_.push(byte);
    if (!line) continue;
    const auto command = parse_command(*line);
    if (!command) continue;
    if (pending_) {
      ++lost_lines_;
    } else {
      pending_ = command;
      run_pending();
    }
  }
}

void FirmwareBoard::run_pending() {
  if (!pending_ || printing(time_) || !takes_commands()) return;
  const Command command = *pending_;
  pending_.reset();
  execute(command);
}

void FirmwareBoard::run_until(Utime now) {
  while (true) {
    // A line that waited for the printing to end comes before the next tick.
    if (pending_ && takes_commands() && printing_until_ <= std::min(now, next_tick_)) {
      time_ = std::max(time_, printing_until_);
      run_pending();
      continue;
    }
    if (next_tick_ > now) break;
    time_ = next_tick_;
    next_tick_ = next_tick_ + Duration::from_us(kTickUs);
    physics_tick();
    if (printing(time_)) {
      ++skipped_ticks_;
      continue;
    }
    firmware_tick();
    wait_.tick();
    main_loop();
    if (wait_.armed() && wait_.over(wait_conditions())) {
      wait_.clear();
      print("w\n");
    }
  }
  time_ = std::max(time_, now);
}

void FirmwareBoard::advance(Utime now, std::vector<uint8_t>& out) {
  if (!started_) start(now);
  run_until(now);
  while (!sent_.empty() && sent_.front().leaves <= now) {
    if (connected_ && readable_) out.push_back(sent_.front().byte);
    sent_.pop_front();
  }
}

Utime FirmwareBoard::next_event() const {
  if (!started_) return Utime{};
  return sent_.empty() ? next_tick_ : std::min(next_tick_, sent_.front().leaves);
}

void FirmwareBoard::print(const std::string& text) {
  const Utime from = std::max(time_, printing_until_);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto us = static_cast<int64_t>(kByteUs * static_cast<double>(i + 1));
    sent_.push_back({from + Duration::from_us(us), static_cast<uint8_t>(text[i])});
  }
  if (!text.empty()) printing_until_ = sent_.back().leaves;
}

}  // namespace marco::drivers::hcs12
