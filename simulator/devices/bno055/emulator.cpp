#include "simulator/devices/bno055/emulator.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/transport/little_endian.hpp"

namespace marco::drivers::bno055 {
namespace {

constexpr Duration kAnswers = Duration::from_us(1000);
constexpr Duration kSlow = Duration::from_us(200'000);
constexpr uint8_t kWrongAddress = 0x04;
constexpr std::size_t kLastRegister = 0x6A;
constexpr std::size_t kMode = 0x3D, kUnitsAt = 0x3B;
constexpr uint8_t kMilliG = 1, kRadians = 2;  // bits of the units

unsigned word_of(double value) {
  return static_cast<unsigned>(std::clamp(std::lround(value), -32768L, 32767L)) & 0xFFFFU;
}

}  // namespace

Bno055Emulator::Bno055Emulator(std::function<imu::Motion(Utime)> motion,
                               const Bno055EmulatorOptions& options)
    : motion_(std::move(motion)), options_(options), random_(options.seed) {
  power_cycle({});
  ready_ = {};  // the first client finds it running
}

void Bno055Emulator::on_connection(bool /*connected*/, Utime /*now*/) {
  parser_.clear();
  output_.clear();
}

void Bno055Emulator::power_cycle(Utime now) {
  parser_.clear();
  output_.clear();
  registers_.fill(0);
  registers_[0] = kChipId;
  registers_[1] = 0xFB;         // accelerometer
  registers_[2] = 0x32;         // magnetometer
  registers_[3] = 0x0F;         // gyroscope
  registers_[0x36] = 0x0F;      // the self test is passed
  registers_[kUnitsAt] = 0x80;  // m/s^2, deg/s; pitch as Android's
  ready_ = now + Duration::from_seconds(options_.start_s);
}

void Bno055Emulator::measure(Utime now) {
  if (registers_[kMode] < static_cast<uint8_t>(Mode::fusion)) return;
  std::normal_distribution<double> noise(0.0, options_.rate_noise_deg_per_s);
  const imu::Motion motion = motion_(now);
  constexpr double kDegPerRad = 57.29577951308232;
  const bool milli_g = (registers_[kUnitsAt] & kMilliG) != 0;
  const double rate_unit = (registers_[kUnitsAt] & kRadians) != 0 ? 900.0 / kDegPerRad : 16.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const double acceleration = motion.acceleration_m_per_s2[i];
    set_u16(registers_, 0x08 + 2 * axis,
            word_of(milli_g ? acceleration / imu::kGravity * 1000.0 : acceleration * 100.0));
    const double bias = axis == 2 ? options_.bias_deg_per_s : 0.0;
    const double rate = motion.rates_rad_per_s[i] * kDegPerRad + bias + noise(random_);
    set_u16(registers_, 0x14 + 2 * axis, word_of(rate * rate_unit));
  }
}

Bytes Bno055Emulator::answer_to(const Request& request, Utime now) {
  if (request.first + request.count > kLastRegister + 1) return status_reply(kWrongAddress);
  if (request.write) {
    for (std::size_t i = 0; i < request.data.size(); ++i) {
      const std::size_t at = request.first + i;
      const bool settable = at == kMode || mode() == Mode::configuration;
      if (settable && at >= kUnitsAt) registers_[at] = request.data[i];
    }
    return status_reply(kWritten);
  }
  measure(now);
  return data_reply(std::span(registers_).subspan(request.first, request.count));
}

void Bno055Emulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  if (now < ready_ || (baud != 0 && baud != kBaud)) return;
  parser_.push(bytes);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  while (const auto request = parser_.next()) {
    const bool fuses = mode() != Mode::configuration;
    if (fuses && chance(random_) < options_.overrun_part) {
      output_.send(status_reply(kOverrun), now + kAnswers);
      continue;
    }
    const Duration takes = fuses && chance(random_) < options_.slow_part ? kSlow : kAnswers;
    output_.send(answer_to(*request, now + takes), now + takes);
  }
}

}  // namespace marco::drivers::bno055
