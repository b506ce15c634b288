#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// CoLa A, the text protocol of SICK's TiM5xx and LMS1xx: 02h, words with one space between them,
/// 03h; no checksum. Numbers are hexadecimal, or decimal behind a sign. From SICK's telegram
/// listings as other drivers read them (sick_scan_xd, sick_tim, LMS1xx); no device was at hand. Not
/// said by any: that token 9 is of the first beam, and that values 1 to 15 are error codes.
namespace marco::drivers::cola {

using Bytes = std::vector<uint8_t>;

inline constexpr std::size_t kMostText = 65'536;  ///< characters of a telegram
inline constexpr uint32_t kMostBeams = 16'384;
inline constexpr double kAheadDeg = 90.0;  ///< straight ahead, by the laser's own angles

Bytes encode_telegram(std::string_view text);

struct Telegram {
  std::string text;             ///< between 02h and 03h
  std::size_t bytes_after = 0;  ///< pushed already, behind it
};

/// Finds telegrams however they are split, and again after damage.
class TelegramParser {
 public:
  void push(std::span<const uint8_t> bytes);
  std::optional<Telegram> next();
  void clear();

  int64_t garbage_bytes() const { return garbage_bytes_; }
  /// Whether bytes since the last telegram began as one of CoLa B, the binary dialect.
  bool heard_binary() const { return heard_binary_; }

 private:
  void drop(std::size_t count);

  std::string buffer_;
  std::size_t head_ = 0;
  std::size_t looked_ = 0;  ///< behind head_: no 03h up to here
  int64_t garbage_bytes_ = 0;
  bool heard_binary_ = false;
};

/// "sFA 3": the laser refuses a request. @returns the number, as it is written; nothing otherwise.
std::optional<std::string> refusal(std::string_view text);

/// A row of values, one a beam.
struct Channel {
  std::string name;      ///< DIST1: ranges of the first echo [mm]; RSSI1: intensities
  double scale = 1.0;    ///< with offset: value * scale + offset
  double offset = 0.0;   ///< sent as floats
  int32_t start_e4 = 0;  ///< angle of the first value, 1/10000 deg, counter-clockwise
  int32_t step_e4 = 0;
  std::vector<uint16_t> values;
  bool operator==(const Channel&) const = default;

  double scaled(std::size_t i) const { return values[i] * scale + offset; }
};

struct Encoder {
  uint32_t position = 0;
  uint32_t speed = 0;
  bool operator==(const Encoder&) const = default;
};

/// "year, month, day, hours, minutes, seconds, microseconds" of the laser's own clock.
using DeviceTime = std::vector<uint32_t>;

/// LMDscandata with all that it may carry but positions and events, which are skipped.
struct ScanData {
  uint32_t version = 1;
  uint32_t device = 1;
  uint32_t serial = 0;
  uint32_t status = 0;  ///< 0 fine, 1 error, 2 and 5 dirty window
  uint32_t telegrams = 0;
  uint32_t scans = 0;
  uint32_t begin_us = 0;  ///< of the laser's clock at the first beam; wraps
  uint32_t sent_us = 0;
  uint32_t inputs = 0;
  uint32_t outputs = 0;
  uint32_t rate_chz = 0;  ///< turns a second, 0.01 Hz
  /// 100 Hz. Some lasers tell a hundred times as much, or another rate: do not use it.
  uint32_t sample_rate = 0;
  std::vector<Encoder> encoders;
  std::vector<Channel> wide;    ///< of 16 bits
  std::vector<Channel> narrow;  ///< of 8 bits
  std::string name;             ///< that an owner gave the laser; "" = not sent
  std::string comment;
  DeviceTime time;  ///< empty = not sent
  bool operator==(const ScanData&) const = default;

  /// Of either width. @returns nullptr when the laser does not send it.
  const Channel* channel(std::string_view name) const;
};

/// @param type  "sSN" of a stream, "sRA" of an answer. Status, inputs and outputs are two words.
std::string encode_scan(const ScanData& scan, std::string_view type);
/// @returns nothing when `text` is no scan, or one that is not whole.
std::optional<ScanData> decode_scan(std::string_view text);

/// "TiM561", "LMS10x_FieldEval": from the answer to DeviceIdent. "" = neither of the families.
std::string model_of(std::string_view identity);
/// [m], of white surfaces, by the data sheets; 25 m of models not known.
double range_max_of(std::string_view model);

}  // namespace marco::drivers::cola
