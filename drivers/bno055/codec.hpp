#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/transport/unread_bytes.hpp"

/// Bosch BNO055 by UART, 115200 baud: the host reads and writes registers, no checksum.
///
///     AA | 00 | register | n | data   ->  EE | 01
///     AA | 01 | register | n          ->  BB | n | data, or EE | code
///
/// From the data sheet (BST-BNO055-DS000) and public drivers; no sensor was at hand.
namespace marco::drivers::bno055 {

using Bytes = std::vector<uint8_t>;

inline constexpr int kBaud = 115'200;
inline constexpr std::size_t kMostBytes = 128;  ///< of one request
inline constexpr uint8_t kChipId = 0xA0;

enum class Register : uint8_t {
  chip_id = 0x00,
  acceleration = 0x08,  ///< x y z, magnet x y z, rates x y z: s16 each, low byte first
  rates = 0x14,
  units = 0x3B,
  mode = 0x3D,
  trigger = 0x3F,
};
inline constexpr std::size_t kMotionBytes = 18;  ///< from `acceleration` to the last rate

enum class Mode : uint8_t {
  configuration = 0x00,
  fusion = 0x08,  ///< acceleration and gyroscope; the gyroscope calibrates itself
};

inline constexpr uint8_t kUnits = 0x00;  ///< m/s^2, deg/s
inline constexpr double kMetresPerS2 = 0.01;
inline constexpr double kRadPerS = 0.017453292519943295 / 16.0;

Bytes read_request(Register first, std::size_t count);
Bytes write_request(Register which, uint8_t value);

struct Request {
  bool write = false;
  uint8_t first = 0;
  std::size_t count = 0;  ///< to read
  Bytes data;             ///< to write
};
/// Takes a host's requests apart, for the emulator.
class RequestParser : public UnreadParser {
 public:
  std::optional<Request> next();
};

Bytes data_reply(std::span<const uint8_t> data);
Bytes status_reply(uint8_t code);

/// Code of a status: the sensor had no time, which is common while it fuses.
inline constexpr uint8_t kOverrun = 0x07;
inline constexpr uint8_t kWritten = 0x01;

struct Reply {
  std::optional<uint8_t> status;  ///< or
  Bytes data;
};
/// Parses the sensor's replies. Only the request determines where a reply begins.
class ReplyParser : public UnreadParser {
 public:
  /// A request has been sent: what came before is forgotten. @param count  bytes to read; 0 = it
  /// writes
  void expect(std::size_t count);
  std::optional<Reply> next();

 private:
  std::size_t count_ = 0;
};

}  // namespace marco::drivers::bno055
