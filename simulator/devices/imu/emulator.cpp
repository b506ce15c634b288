#include "simulator/devices/imu/emulator.hpp"

#include <algorithm>
#include <cmath>

namespace marco::drivers::imu {
namespace {

constexpr uint16_t kAccelerationBit = 0x02, kRatesBit = 0x04, kAnglesBit = 0x08;
constexpr uint8_t kUnlock = 0x69;

int16_t word_of(double value, double unit) {
  return static_cast<int16_t>(std::clamp(std::lround(value / unit), -32768L, 32767L));
}

}  // namespace

ImuEmulator::ImuEmulator(std::function<Motion(Utime)> motion, const ImuEmulatorOptions& options)
    : motion_(std::move(motion)),
      options_(options),
      random_(options.seed),
      output_(options.baud),
      bias_deg_per_s_(options.bias_deg_per_s) {}

void ImuEmulator::on_connection(bool /*connected*/, Utime /*now*/) {
  output_.clear();
  command_.clear();
  readable_ = true;
}

void ImuEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime /*now*/) {
  readable_ = baud == 0 || baud == options_.baud;
  if (!readable_) return;
  for (const uint8_t byte : bytes) {
    command_.push_back(byte);
    const bool begins = command_[0] == 0xFF && (command_.size() < 2 || command_[1] == 0xAA);
    if (!begins) command_.clear();
    if (command_.size() < 5) continue;
    execute(command_[2], static_cast<uint16_t>(command_[3] | command_[4] << 8));
    command_.clear();
  }
}

void ImuEmulator::execute(uint8_t which, uint16_t value) {
  if (which == kUnlock) {
    unlocked_ = value == 0xB588;
    return;
  }
  if (!unlocked_) return;
  if (which == static_cast<uint8_t>(Register::content)) content_ = value;
  if (which != static_cast<uint8_t>(Register::rate)) return;
  for (const int rate : {1, 2, 5, 10, 20, 50, 100, 200}) {
    if (rate_code(rate) == value) rate_hz_ = rate;
  }
}

void ImuEmulator::measure(Utime when) {
  std::normal_distribution<double> noise(0.0, 1.0);
  bias_deg_per_s_ += options_.drift_deg_per_s_sqrt_s / std::sqrt(rate_hz_) * noise(random_);
  const Motion motion = motion_(when);
  Frame acceleration, rates, angles;
  acceleration.kind = static_cast<uint8_t>(Kind::acceleration);
  rates.kind = static_cast<uint8_t>(Kind::rates);
  angles.kind = static_cast<uint8_t>(Kind::angles);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    acceleration.values[axis] = word_of(
        motion.acceleration_m_per_s2(i) + options_.acceleration_noise_m_per_s2 * noise(random_),
        kMetresPerS2);
    const double bias = i == 2 ? bias_deg_per_s_ : 0.0;
    const double off = (bias + options_.rate_noise_deg_per_s * noise(random_)) * M_PI / 180.0;
    rates.values[axis] = word_of(motion.rates_rad_per_s(i) + off, kRadPerS);
  }
  if ((content_ & kAccelerationBit) != 0) output_.send(encode_frame(acceleration), when);
  if ((content_ & kRatesBit) != 0) output_.send(encode_frame(rates), when);
  if ((content_ & kAnglesBit) != 0) output_.send(encode_frame(angles), when);
}

void ImuEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  if (next_sample_ == Utime{}) next_sample_ = now;  // power-on
  while (next_sample_ <= now) {
    measure(next_sample_);
    next_sample_ = next_sample_ + Duration::from_us(1'000'000 / rate_hz_);
  }
  std::vector<uint8_t> sent;
  output_.advance(now, sent);
  if (readable_) out.insert(out.end(), sent.begin(), sent.end());
}

}  // namespace marco::drivers::imu
