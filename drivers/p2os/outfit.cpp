#include "drivers/p2os/outfit.hpp"

#include <algorithm>

namespace marco::drivers::p2os {
namespace {

constexpr int kAskedAtMost = 3;

}  // namespace

void Outfit::on_asked(Utime now) {
  constexpr double kPatienceS = 0.3;  // the answer takes 0.15 s at 9600 baud
  ++times_asked_;
  next_ask_ = now + Duration::from_seconds(kPatienceS);
}

bool Outfit::on_config(std::span<const uint8_t> payload) {
  config_ = decode_config(payload);
  return config_.has_value();
}

bool Outfit::must_ask(Utime now) const {
  return !config_ && now >= next_ask_ && times_asked_ < kAskedAtMost;
}

bool Outfit::known(Utime now) const {
  return config_ || (now >= next_ask_ && times_asked_ >= kAskedAtMost);
}

std::string Outfit::note() const {
  constexpr int kLongWatchdogMs = 3000;
  if (!config_) {
    return "the robot does not report its bumpers: assuming " + std::to_string(bumpers_each_end_) +
           " at each end (bumpers_each_end)";
  }
  if (config_->watchdog_ms == 0) {
    return "the robot's watchdog is off: it will not stop if the line is cut";
  }
  if (config_->watchdog_ms <= kLongWatchdogMs) return "";
  return "the robot's watchdog stops it only " + std::to_string(config_->watchdog_ms) +
         " ms after the line is cut";
}

Outfit::Bumpers Outfit::bumpers(const Sip& sip) const {
  constexpr int kBits = 7;  // beside the stall
  Bumpers bumpers;
  const auto read = [&](uint8_t bits, int fitted) {
    std::vector<int> pressed;
    for (int i = 0; i < fitted; ++i) {
      bumpers.all.push_back((bits >> (i + 1) & 1) != 0);
      if (bumpers.all.back()) pressed.push_back(i + 1);
    }
    return pressed;
  };
  const auto fitted = [&](int RobotConfig::*end) {
    return config_ ? std::clamp((*config_).*end, 0, kBits) : bumpers_each_end_;
  };
  // The byte of the right wheel carries the front bumpers.
  bumpers.front_pressed = read(sip.right_stall, fitted(&RobotConfig::front_bumpers));
  bumpers.rear_pressed = read(sip.left_stall, fitted(&RobotConfig::rear_bumpers));
  return bumpers;
}

}  // namespace marco::drivers::p2os
