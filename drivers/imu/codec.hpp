#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/transport/unread_bytes.hpp"

/// Frames of WitMotion's serial sensors (WT61, WT901, JY901 and their like), which many own:
///
///     55 | kind | 4 x s16 little endian | sum        sum = low byte of all before it
///
/// kind 51: acceleration, full scale 16 g; 52: turning rates, 2000 deg/s; 53: angles, 180 deg. The
/// fourth number is temperature or voltage. Settings: FF AA | register | u16, after an unlocking.
namespace marco::drivers::imu {

using Bytes = std::vector<uint8_t>;
inline constexpr std::size_t kFrameBytes = 11;

enum class Kind : uint8_t { acceleration = 0x51, rates = 0x52, angles = 0x53 };

struct Frame {
  uint8_t kind = 0;
  std::array<int16_t, 4> values{};
  bool operator==(const Frame&) const = default;
};
Bytes encode_frame(const Frame& frame);

/// Cuts a stream into frames; never delivers one whose sum does not fit.
class FrameParser : public UnreadParser {
 public:
  std::optional<Frame> next();
  std::size_t waiting() const { return unread_.size(); }
};

inline constexpr double kGravity = 9.80665;  ///< [m/s^2] of the sensor's g
inline constexpr double kMetresPerS2 = 16.0 * kGravity / 32768.0;
inline constexpr double kRadPerS = 2000.0 / 32768.0 * 0.017453292519943295;

enum class Register : uint8_t { save = 0x00, content = 0x02, rate = 0x03, baud = 0x04 };
inline constexpr uint16_t kContentRatesAndAcceleration = 0x06;
Bytes unlock_request();
Bytes set_request(Register which, uint16_t value);
/// @returns the register's value for a rate the sensor knows: 1 2 5 10 20 50 100 200 Hz.
std::optional<uint16_t> rate_code(int rate_hz);

}  // namespace marco::drivers::imu
