#pragma once

#include <optional>
#include <string>

#include "drivers/p2os/codec.hpp"
#include "lcm_tools/base/utime.hpp"

/// Packets that a robot sends only when asked: CONFIG, ENCODER, IOREQUEST, the gripper's, GETAUX.
/// Their fields in the order in which ARIA reads them.

namespace marco::drivers::p2os {

inline constexpr uint8_t kConfigPacket = 0x20;
inline constexpr uint8_t kEncoderPacket = 0x90;
inline constexpr uint8_t kAuxPacket = 0xB0;
inline constexpr uint8_t kGripperPacket = 0xE0;
inline constexpr uint8_t kIoPacket = 0xF0;

/// What the robot is set to; millimetres, degrees, seconds.
struct RobotConfig {
  RobotName name;
  std::string serial_number;
  int rotation_top = 500, velocity_top = 2200;
  int rotation_acceleration_top = 300, acceleration_top = 2000;
  int cycle_ms = 100;
  int host_baud = 0;      ///< as of HOSTBAUD
  int low_battery = 115;  ///< tenths of a volt
  int watchdog_ms = 2000;
  int velocity_max = 0, rotation_max = 0;
  int acceleration = 0, deceleration = 0;
  int rotation_acceleration = 0, rotation_deceleration = 0;
  int front_bumpers = 5, rear_bumpers = 5;
  int ticks_per_mm = 0;
  std::string firmware = "2.6";
  bool operator==(const RobotConfig&) const = default;
};
Bytes encode_config(const RobotConfig& config);
/// @returns nothing for another or a shorter packet.
std::optional<RobotConfig> decode_config(std::span<const uint8_t> payload);

/// Ticks since power-on, left and right.
struct Encoders {
  int32_t left = 0, right = 0;
  bool operator==(const Encoders&) const = default;
};
Bytes encode_encoders(const Encoders& encoders);
std::optional<Encoders> decode_encoders(std::span<const uint8_t> payload);

struct IoPorts {
  Bytes digital_in, digital_out;
  std::vector<uint16_t> analog;
  bool operator==(const IoPorts&) const = default;
};
Bytes encode_io(const IoPorts& ports);
std::optional<IoPorts> decode_io(std::span<const uint8_t> payload);

/// Bytes that came in at the second serial port.
Bytes encode_aux(std::span<const uint8_t> bytes);

/// What the robot has and how it is set. It is asked (CONFIG) until it answers or has shown that it
/// does not, as old firmware.
class Outfit {
 public:
  /// @param bumpers_each_end  of a robot that does not tell.
  explicit Outfit(int bumpers_each_end) : bumpers_each_end_(bumpers_each_end) {}

  void restart() { config_.reset(), times_asked_ = 0; }
  void on_asked(Utime now);
  /// @returns false for a damaged packet.
  bool on_config(std::span<const uint8_t> payload);
  bool must_ask(Utime now) const;
  bool known(Utime now) const;
  /// What a person should know; "" = nothing.
  std::string note() const;

  struct Bumpers {
    std::vector<int> front_pressed;  ///< numbers, 1 = the leftmost
    std::vector<int> rear_pressed;
    std::vector<bool> all;
  };
  Bumpers bumpers(const Sip& sip) const;

 private:
  int bumpers_each_end_;
  std::optional<RobotConfig> config_;
  int times_asked_ = 0;
  Utime next_ask_;
};

}  // namespace marco::drivers::p2os
