#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/transport/unread_bytes.hpp"

/// Yujin Robot's Kobuki, the base of the TurtleBot 2. Both sides send frames of parts
///
///     AA 55 | n | id size data, id size data ... | xor        xor of all from n on is 0
///
/// with little-endian numbers. The robot sends one every 20 ms, unasked. From notes on the Kobuki
/// protocol specification and kobuki_core; no robot was at hand. Not said there, and assumed: the
/// bits of the cliff sensors are those of the bumpers, and a robot that receives nothing keeps its
/// last speed.
namespace marco::drivers::kobuki {

using Bytes = std::vector<uint8_t>;

inline constexpr int kBaud = 115'200;
inline constexpr double kFrameS = 0.02;
inline constexpr double kTicksPerM = 11'724.4166;
inline constexpr double kTrackM = 0.23;
inline constexpr double kGyroDegPerS = 0.00875;  ///< of a count

/// Three sensors each: right, centre, left are bits 0, 1, 2.
inline constexpr uint8_t kRight = 1, kCentre = 2, kLeft = 4;

/// What the robot says of itself in each frame.
struct Feedback {
  uint16_t clock_ms = 0;       ///< wraps
  uint8_t bumpers = 0;         ///< bits kRight, kCentre, kLeft
  uint8_t hanging_wheels = 0;  ///< bit 0 right, bit 1 left
  uint8_t cliffs = 0;          ///< bits kRight, kCentre, kLeft
  uint16_t left_ticks = 0;     ///< wrap
  uint16_t right_ticks = 0;
  uint8_t charger = 0;       ///< 2, 6: on its dock, full or charging; 0x12, 0x16: by a cable
  uint8_t decivolts = 0;     ///< of the battery
  int16_t heading_cdeg = 0;  ///< 0.01 deg, counter-clockwise
  int16_t rate_cdeg_per_s = 0;
  /// The gyro's readings in this frame, x, y, z in its own frame; mostly two, or three.
  std::vector<std::array<int16_t, 3>> gyro;
  /// Major, minor, patch: only in the answer to version_request().
  std::optional<std::array<uint8_t, 3>> firmware;

  bool on_cable() const { return (charger & 0x10) != 0; }
  bool operator==(const Feedback&) const = default;
};

/// Speed and turn until the next order: the wire has the speed of the outer wheel's circle and its
/// radius, whole millimetres. Speeds beyond its 16 bits are cut.
Bytes velocity_request(double velocity_m_per_s, double yaw_rate_rad_per_s);
/// "say the versions of your hardware and firmware".
Bytes version_request();

/// Of the emulator.
Bytes encode_frame(const Feedback& feedback);
/// @param payload  of a frame, without head and sum. @returns nothing without the robot's basic
/// part or when a part is cut off or has an impossible size. Unknown parts are skipped.
std::optional<Feedback> decode_feedback(std::span<const uint8_t> payload);

/// A host's order, for the emulator.
struct Order {
  std::optional<double> velocity_m_per_s;  ///< with the yaw rate, or neither
  double yaw_rate_rad_per_s = 0.0;
  bool asks_versions = false;
};
/// @returns nothing when a part is cut off.
std::optional<Order> decode_order(std::span<const uint8_t> payload);

/// Finds payloads however frames are split, and again after damage.
class FrameParser : public UnreadParser {
 public:
  struct Received {
    Bytes payload;
    std::size_t bytes_after = 0;  ///< pushed already, behind the frame
  };
  std::optional<Received> next();
};

}  // namespace marco::drivers::kobuki
