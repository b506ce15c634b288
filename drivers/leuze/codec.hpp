#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/transport/unread_bytes.hpp"

/// Leuze Rotoscan RS4: its native telegram (serial, TCP), and the socket service that thesis A put
/// in front of it.
///
///     00 00 | op | options | scan number b3 FE b2 FE b1 FE b0 FE | step | start | stop | values |
///     checksum | 00 00 00
///
/// big endian. Inside, two zeros in a row are followed by a stuffed FF, so that only the ends have
/// more. The checksum is the xor from op to the last value, stuffing included; 00 is sent as FF. It
/// is weak: a zero lost in front of a stuffed FF goes unnoticed and makes a 0 a 254.
namespace marco::drivers::leuze {

using Bytes = std::vector<uint8_t>;

inline constexpr uint8_t kMeasurement = 0x23;
inline constexpr uint8_t kError = 0x53;
inline constexpr uint8_t kWarning = 0x54;

/// Bits of the first option byte beside the count of option bytes (bits 0-1).
inline constexpr uint8_t kErrorBit = 0x10;
inline constexpr uint8_t kPasswordFollows = 0x20;

struct Telegram {
  uint8_t operation = kMeasurement;
  Bytes options{0x09};  ///< 1 to 3; the first says how many
  uint32_t scan_number = 0;
  int step = 4;                     ///< index of a beam to the next
  int first = 1;                    ///< index of the first beam, 1..529
  std::vector<uint16_t> values_mm;  ///< bit 0 is a flag, taken off
  bool operator==(const Telegram&) const = default;

  int last() const { return first + step * (static_cast<int>(values_mm.size()) - 1); }
};

Bytes encode_telegram(const Telegram& telegram);

/// From op to the last value, stuffing removed. @returns nothing when it is inconsistent.
std::optional<Telegram> decode_body(std::span<const uint8_t> body);

/// Parses a stream into telegrams, however it is split. Drops and counts wrong checksums.
class TelegramParser : public UnreadParser {
 public:
  std::optional<Telegram> next();
  std::size_t bytes_after() const { return unread_.size(); }
  void clear();

  int64_t garbage_bytes() const { return garbage_bytes_; }
  int64_t bad_checksums() const { return bad_checksums_; }

 private:
  std::optional<Telegram> finish();
  std::optional<Telegram> take(uint8_t byte);

  bool inside_ = false;
  int zeros_ = 0;  ///< in a row
  Bytes body_;
  int stuffed_ = 0;
  int64_t bad_checksums_ = 0;
  int64_t garbage_bytes_ = 0;
};

// ---- thesis A's service: a connection a scan ----------------------------------------------------

inline constexpr int kServiceBeams = 133;
inline constexpr std::size_t kServiceBytes = std::size_t{4} * kServiceBeams;
inline constexpr int kServiceStep = 4;  ///< index of a beam to the next

/// What the client sends: the number 1.
std::array<uint8_t, 4> service_request();
/// 133 ranges [m, before calibration] as little-endian floats.
Bytes encode_service_answer(std::span<const float> ranges);
/// @returns nothing unless there are 133 finite ranges.
std::optional<std::vector<float>> decode_service_answer(std::span<const uint8_t> bytes);

}  // namespace marco::drivers::leuze
