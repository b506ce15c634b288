#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/pose2.hpp"
#include "drivers/transport/unread_bytes.hpp"

/// Packets of ActivMedia's Pioneer robots (P2OS, ARCOS):
///
///     FA FB | n | payload | sum u16 big endian          n = payload + 2
///
/// The payload's numbers are little endian. Nothing is acknowledged, nothing sent again.
namespace marco::drivers::p2os {

using Bytes = std::vector<uint8_t>;

inline constexpr int kBaud = 9600;
inline constexpr std::size_t kMaxPayload = 200;

/// Sum of big-endian pairs; a byte left over is exclusive-ored into the low byte.
uint16_t checksum(std::span<const uint8_t> payload);
/// @throws std::invalid_argument for an empty or too long payload.
Bytes encode_packet(std::span<const uint8_t> payload);

/// Cuts a stream into packets, however it is split; after damage it continues one byte behind the
/// false beginning, so that the next whole packet is found. Never delivers one whose sum does not
/// fit.
class PacketParser : public UnreadParser {
 public:
  /// The next payload within what was pushed.
  std::optional<Bytes> next();
  int64_t bad_checksums() const { return bad_checksums_; }

 private:
  int64_t bad_checksums_ = 0;
};

/// Commands of the host. In the sync phase 0, 1 and 2 mean SYNC.
enum class CommandId : uint8_t {
  pulse = 0,
  open = 1,
  close = 2,
  polling = 3,
  enable = 4,
  set_acceleration = 5,
  set_max_velocity = 6,
  set_origin = 7,
  move = 8,
  rotate = 9,
  set_max_rate = 10,
  velocity = 11,
  heading = 12,
  turn_by = 13,
  say = 15,
  joystick_info = 17,
  config = 18,
  encoder = 19,
  rotation_velocity = 21,
  set_rotation_acceleration = 23,
  sonar = 28,
  stop = 29,
  digital_out = 30,
  wheel_velocities = 32,
  gripper = 33,
  gripper_request = 37,
  io_request = 40,
  tty2 = 42,     ///< text goes to the second serial port
  get_aux = 43,  ///< asks for this many bytes of what came in there
  bump_stall = 44,
  host_baud = 50,
  emergency_stop = 55,
};

struct Command {
  CommandId id = CommandId::pulse;
  std::optional<int> value;  ///< -65535..65535: sign and sixteen bits
  std::string text;
  bool operator==(const Command&) const = default;
};
Bytes encode_command(const Command& command);
std::optional<Command> decode_command(std::span<const uint8_t> payload);

/// The robot's answer to SYNC2.
struct RobotName {
  std::string name, type, subtype;
  bool operator==(const RobotName&) const = default;
};
Bytes encode_name(const RobotName& name);
std::optional<RobotName> decode_name(std::span<const uint8_t> payload);

/// Server information packet, raw units.
struct Sip {
  struct Sonar {
    uint8_t number = 0;
    uint16_t range = 0;
    bool operator==(const Sonar&) const = default;
  };
  bool moving = false;
  uint16_t x = 0;  ///< fifteen bits, wraps
  uint16_t y = 0;
  int16_t heading = 0;  ///< 4096 a turn
  int16_t left_speed = 0;
  int16_t right_speed = 0;
  uint8_t battery = 0;      ///< tenths of a volt
  uint8_t left_stall = 0;   ///< bit 0; bits 1.. rear bumpers
  uint8_t right_stall = 0;  ///< bit 0; bits 1.. front bumpers
  int16_t control = 0;
  uint16_t flags = 0;  ///< bit 0 motors enabled
  uint8_t compass = 0;
  std::vector<Sonar> sonars;
  uint16_t analog_port = 0;
  uint8_t analog = 0;
  uint8_t digital_in = 0xFF;
  uint8_t digital_out = 0;
  bool operator==(const Sip&) const = default;
};
Bytes encode_sip(const Sip& sip);
/// Bytes beyond the standard fields, which newer firmware sends, are ignored.
std::optional<Sip> decode_sip(std::span<const uint8_t> payload);

}  // namespace marco::drivers::p2os
