#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/transport/unread_bytes.hpp"

/// iRobot's Open Interface: Create 2, Roomba 500 and 600. Requests are an opcode and its data;
/// numbers are big endian. Asked to stream, the robot sends every 15 ms
///
///     13 | n | id data, id data ... | sum         all bytes with 13 sum to 0
///
/// From notes on iRobot's Create 2 Open Interface Specification (2015) and libcreate; no robot was
/// at hand.
/// Not said by the document, and taken from libcreate's users: that a robot which falls silent
/// keeps its last wheel speeds, and that some firmware reports its mode one too high.
namespace marco::drivers::create {

using Bytes = std::vector<uint8_t>;

inline constexpr int kBaud = 115'200;
inline constexpr double kStreamS = 0.015;
inline constexpr double kTicksPerTurn = 508.8;
inline constexpr double kWheelDiameterM = 0.072;
inline constexpr double kTrackM = 0.235;
inline constexpr int kMostMmPerS = 500;

enum class Opcode : uint8_t {
  reset = 0x07,
  start = 0x80,
  safe = 0x83,
  full = 0x84,
  power_off = 0x85,
  drive = 0x89,  ///< by speed and radius
  one_packet = 0x8E,
  drive_wheels = 0x91,
  drive_pwm = 0x92,
  stream = 0x94,
  packets = 0x95,
  pause_stream = 0x96,
  stop = 0xAD,
};

enum class OiMode : uint8_t { off, passive, safe, full };

/// What the driver asks for, in this order.
struct Sensors {
  bool right_bump = false, left_bump = false;
  bool right_drop = false, left_drop = false;  ///< a wheel hangs
  std::array<bool, 4> cliffs{};                ///< left, front left, front right, right
  int charging = 0;  ///< 0 not, 1 recondition, 2 full, 3 trickle, 4 waits, 5 fault
  int millivolts = 0;
  int mode = 0;             ///< OiMode; some firmware says one more
  uint16_t left_ticks = 0;  ///< wrap; go down when the robot was told to drive back
  uint16_t right_ticks = 0;

  bool wheel_drop() const { return right_drop || left_drop; }
  bool cliff() const { return cliffs[0] || cliffs[1] || cliffs[2] || cliffs[3]; }
  bool charges() const { return charging >= 1 && charging <= 4; }
  bool operator==(const Sensors&) const = default;
};

Bytes encode_request(Opcode opcode);
/// "stream these packets": those of Sensors.
Bytes stream_request();
/// Speeds are held until the next order. @throws std::invalid_argument beyond kMostMmPerS.
Bytes drive_request(int left_mm_per_s, int right_mm_per_s);

/// Of the emulator: the packets' data one behind the other, as to a single question; a group of
/// packets (0 to 6, 100, 101, 106, 107) is several. Packets that Sensors does not hold are zeros;
/// unknown ones are left out.
Bytes encode_packets(const Sensors& sensors, std::span<const uint8_t> packets);
/// Of the emulator: a stream's frame.
Bytes encode_frame(const Sensors& sensors, std::span<const uint8_t> packets);
/// With what stream_request() asks for.
Bytes encode_frame(const Sensors& sensors);
/// @param frame  whole, from 13 to the sum. @returns nothing when the sum is wrong, a packet is
/// unknown, or one of Sensors is missing.
std::optional<Sensors> decode_frame(std::span<const uint8_t> frame);

/// Finds frames however they are split, and again after damage.
class FrameParser : public UnreadParser {
 public:
  struct Received {
    Sensors sensors;
    std::size_t bytes_after = 0;  ///< pushed already, behind it
  };
  std::optional<Received> next();
};

/// A host's request, for the emulator.
struct Request {
  Opcode opcode = Opcode::start;
  Bytes data;
};
class RequestParser : public UnreadParser {
 public:
  std::optional<Request> next();
};

}  // namespace marco::drivers::create
