#include "drivers/p2os/accessories.hpp"

#include <algorithm>

namespace marco::drivers::p2os {
namespace {

// Constants of the board that nothing here depends on: PWM, encoder count, stall, loop gains.
constexpr int kPwmMax = 500, kTurnCount = 16570, kStallPwm = 200, kStallCount = 50;
constexpr int kJoyVelocity = 750, kJoyRotation = 70;
constexpr int kRotationGains[] = {40, 20, 0}, kVelocityGains[] = {40, 20, 0};
constexpr int kSonarCycleMs = 40;

class Writer {
 public:
  explicit Writer(uint8_t id) { bytes_.push_back(id); }
  void u8(int value) { bytes_.push_back(static_cast<uint8_t>(value)); }
  void u16(int value) {
    u8(value & 0xFF);
    u8(value >> 8 & 0xFF);
  }
  void u32(uint32_t value) {
    u16(static_cast<int>(value & 0xFFFF));
    u16(static_cast<int>(value >> 16));
  }
  void text(const std::string& text) {
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }
  Bytes packet() const { return encode_packet(bytes_); }

 private:
  Bytes bytes_;
};

/// Gives zeros behind the end, and says so.
class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : rest_(bytes.subspan(1)) {}
  int u8() {
    if (rest_.empty()) {
      good_ = false;
      return 0;
    }
    const int value = rest_[0];
    rest_ = rest_.subspan(1);
    return value;
  }
  int u16() {
    const int low = u8();
    return low | u8() << 8;
  }
  int32_t s32() {
    const int low = u16();
    return static_cast<int32_t>(static_cast<uint32_t>(low) | static_cast<uint32_t>(u16()) << 16);
  }
  std::string text() {
    std::string text;
    for (int c = u8(); c != 0; c = u8()) text += static_cast<char>(c);
    return text;
  }
  void skip(int bytes) {
    for (int i = 0; i < bytes; ++i) u8();
  }
  bool good() const { return good_; }

 private:
  std::span<const uint8_t> rest_;
  bool good_ = true;
};

bool is(std::span<const uint8_t> payload, uint8_t id) {
  return !payload.empty() && payload[0] == id;
}

}  // namespace

Bytes encode_config(const RobotConfig& config) {
  Writer out(kConfigPacket);
  out.text(config.name.type);
  out.text(config.name.subtype);
  out.text(config.serial_number);
  out.u8(0);
  out.u16(config.rotation_top);
  out.u16(config.velocity_top);
  out.u16(config.rotation_acceleration_top);
  out.u16(config.acceleration_top);
  out.u16(kPwmMax);
  out.text(config.name.name);
  out.u8(config.cycle_ms);
  out.u8(config.host_baud);
  out.u8(0);   // second port: 9600
  out.u16(0);  // no gripper
  out.u16(1);  // sonars in front
  out.u8(1);   // and behind
  out.u16(config.low_battery);
  out.u16(kTurnCount);
  out.u16(config.watchdog_ms);
  out.u8(0);
  out.u16(kStallPwm);
  out.u16(kStallCount);
  out.u16(kJoyVelocity);
  out.u16(kJoyRotation);
  out.u16(config.rotation_max);
  out.u16(config.velocity_max);
  out.u16(config.rotation_acceleration);
  out.u16(config.rotation_deceleration);
  for (const int gain : kRotationGains) out.u16(gain);
  out.u16(config.acceleration);
  out.u16(config.deceleration);
  for (const int gain : kVelocityGains) out.u16(gain);
  out.u8(config.front_bumpers);
  out.u8(config.rear_bumpers);
  out.u8(0);  // no charger
  out.u8(kSonarCycleMs);
  out.u8(0);   // keeps its baud rate
  out.u8(0);   // no gyro
  out.u16(0);  // no drift known
  out.u8(0);
  out.u8(0);
  out.u16(config.ticks_per_mm);
  out.u16(0);
  out.text(config.firmware);
  return out.packet();
}

std::optional<RobotConfig> decode_config(std::span<const uint8_t> payload) {
  if (!is(payload, kConfigPacket)) return std::nullopt;
  Reader in(payload);
  RobotConfig config;
  config.name.type = in.text();
  config.name.subtype = in.text();
  config.serial_number = in.text();
  in.skip(1);
  config.rotation_top = in.u16();
  config.velocity_top = in.u16();
  config.rotation_acceleration_top = in.u16();
  config.acceleration_top = in.u16();
  in.skip(2);
  config.name.name = in.text();
  config.cycle_ms = in.u8();
  config.host_baud = in.u8();
  in.skip(6);
  config.low_battery = in.u16();
  in.skip(2);
  config.watchdog_ms = in.u16();
  in.skip(9);
  config.rotation_max = in.u16();
  config.velocity_max = in.u16();
  config.rotation_acceleration = in.u16();
  config.rotation_deceleration = in.u16();
  in.skip(6);
  config.acceleration = in.u16();
  config.deceleration = in.u16();
  in.skip(6);
  config.front_bumpers = in.u8();
  config.rear_bumpers = in.u8();
  in.skip(8);
  config.ticks_per_mm = in.u16();
  in.skip(2);
  config.firmware = in.text();
  if (!in.good()) return std::nullopt;
  return config;
}

Bytes encode_encoders(const Encoders& encoders) {
  Writer out(kEncoderPacket);
  out.u32(static_cast<uint32_t>(encoders.left));
  out.u32(static_cast<uint32_t>(encoders.right));
  return out.packet();
}

std::optional<Encoders> decode_encoders(std::span<const uint8_t> payload) {
  if (!is(payload, kEncoderPacket)) return std::nullopt;
  Reader in(payload);
  Encoders encoders;
  encoders.left = in.s32();
  encoders.right = in.s32();
  if (!in.good()) return std::nullopt;
  return encoders;
}

Bytes encode_io(const IoPorts& ports) {
  Writer out(kIoPacket);
  for (const Bytes* bytes : {&ports.digital_in, &ports.digital_out}) {
    out.u8(static_cast<int>(bytes->size()));
    for (const uint8_t byte : *bytes) out.u8(byte);
  }
  out.u8(static_cast<int>(ports.analog.size()));
  for (const uint16_t value : ports.analog) out.u16(value);
  return out.packet();
}

std::optional<IoPorts> decode_io(std::span<const uint8_t> payload) {
  if (!is(payload, kIoPacket)) return std::nullopt;
  Reader in(payload);
  IoPorts ports;
  for (Bytes* bytes : {&ports.digital_in, &ports.digital_out}) {
    for (int left = in.u8(); left > 0; --left) bytes->push_back(static_cast<uint8_t>(in.u8()));
  }
  for (int left = in.u8(); left > 0; --left)
    ports.analog.push_back(static_cast<uint16_t>(in.u16()));
  if (!in.good()) return std::nullopt;
  return ports;
}

Bytes encode_aux(std::span<const uint8_t> bytes) {
  Bytes payload{kAuxPacket};
  payload.insert(payload.end(), bytes.begin(), bytes.end());
  return encode_packet(payload);
}

}  // namespace marco::drivers::p2os
