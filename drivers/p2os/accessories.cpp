#include "drivers/p2os/accessories.hpp"

#include <algorithm>

#include "drivers/p2os/packet_fields.hpp"

namespace marco::drivers::p2os {
namespace {

constexpr int kAskedAtMost = 3;

// Constants of the board that nothing here depends on: PWM, encoder count, stall, loop gains.
constexpr int kPwmMax = 500, kTurnCount = 16570, kStallPwm = 200, kStallCount = 50;
constexpr int kJoyVelocity = 750, kJoyRotation = 70;
constexpr int kRotationGains[] = {40, 20, 0}, kVelocityGains[] = {40, 20, 0};
constexpr int kSonarCycleMs = 40;

template <class Io, class Config>
void config_fields(Io& io, Config& config) {
  io.text(config.name.type);
  io.text(config.name.subtype);
  io.text(config.serial_number);
  io.constant8(0);
  io.u16(config.rotation_top);
  io.u16(config.velocity_top);
  io.u16(config.rotation_acceleration_top);
  io.u16(config.acceleration_top);
  io.constant16(kPwmMax);
  io.text(config.name.name);
  io.u8(config.cycle_ms);
  io.u8(config.host_baud);
  io.constant8(0);   // second port: 9600
  io.constant16(0);  // no gripper
  io.constant16(1);  // sonars in front
  io.constant8(1);   // and behind
  io.u16(config.low_battery);
  io.constant16(kTurnCount);
  io.u16(config.watchdog_ms);
  io.constant8(0);
  io.constant16(kStallPwm);
  io.constant16(kStallCount);
  io.constant16(kJoyVelocity);
  io.constant16(kJoyRotation);
  io.u16(config.rotation_max);
  io.u16(config.velocity_max);
  io.u16(config.rotation_acceleration);
  io.u16(config.rotation_deceleration);
  for (const int gain : kRotationGains) io.constant16(gain);
  io.u16(config.acceleration);
  io.u16(config.deceleration);
  for (const int gain : kVelocityGains) io.constant16(gain);
  io.u8(config.front_bumpers);
  io.u8(config.rear_bumpers);
  io.constant8(0);  // no charger
  io.constant8(kSonarCycleMs);
  io.constant8(0);   // keeps its baud rate
  io.constant8(0);   // no gyro
  io.constant16(0);  // no drift known
  io.constant8(0);
  io.constant8(0);
  io.u16(config.ticks_per_mm);
  io.constant16(0);
  io.text(config.firmware);
}

template <class Io, class Ports>
void io_fields(Io& io, Ports& ports) {
  io.list(ports.digital_in, [&io](auto& byte) { io.u8(byte); });
  io.list(ports.digital_out, [&io](auto& byte) { io.u8(byte); });
  io.list(ports.analog, [&io](auto& value) { io.u16(value); });
}

bool is(std::span<const uint8_t> payload, uint8_t id) {
  return !payload.empty() && payload[0] == id;
}

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

Bytes encode_config(const RobotConfig& config) {
  FieldWriter out(kConfigPacket);
  config_fields(out, config);
  return out.packet();
}

std::optional<RobotConfig> decode_config(std::span<const uint8_t> payload) {
  if (!is(payload, kConfigPacket)) return std::nullopt;
  FieldReader in(payload);
  RobotConfig config;
  config_fields(in, config);
  return in.good() ? std::optional(config) : std::nullopt;
}

Bytes encode_encoders(const Encoders& encoders) {
  FieldWriter out(kEncoderPacket);
  out.s32(encoders.left);
  out.s32(encoders.right);
  return out.packet();
}

std::optional<Encoders> decode_encoders(std::span<const uint8_t> payload) {
  if (!is(payload, kEncoderPacket)) return std::nullopt;
  FieldReader in(payload);
  Encoders encoders;
  in.s32(encoders.left);
  in.s32(encoders.right);
  return in.good() ? std::optional(encoders) : std::nullopt;
}

Bytes encode_io(const IoPorts& ports) {
  FieldWriter out(kIoPacket);
  io_fields(out, ports);
  return out.packet();
}

std::optional<IoPorts> decode_io(std::span<const uint8_t> payload) {
  if (!is(payload, kIoPacket)) return std::nullopt;
  FieldReader in(payload);
  IoPorts ports;
  io_fields(in, ports);
  return in.good() ? std::optional(ports) : std::nullopt;
}

Bytes encode_aux(std::span<const uint8_t> bytes) {
  Bytes payload{kAuxPacket};
  payload.insert(payload.end(), bytes.begin(), bytes.end());
  return encode_packet(payload);
}

}  // namespace marco::drivers::p2os
