#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// SCIP 2.0, the text protocol of Hokuyo's laser scanners (URG-04LX, UTM-30LX ...).
///
/// A request is one line. A reply is its echo, a status of two characters, data lines, and an empty
/// line; every line but the echo ends with a checksum character. Numbers are written with six bits
/// a character, most significant first, each + 30h.
namespace marco::drivers::hokuyo {

using Bytes = std::vector<uint8_t>;

inline constexpr std::size_t kBlock = 64;  ///< characters of data a line

/// Six bits of the sum of the characters.
char checksum(std::string_view text);

/// @param characters  2, 3 or 4.
std::string encode_number(uint32_t value, int characters);
/// @returns nothing when a character lies outside 30h..6Fh.
std::optional<uint32_t> decode_number(std::string_view text);

/// One reply, checksums verified and removed.
struct Reply {
  std::string echo;                ///< the request, without its tag
  std::string status;              ///< "00" done, "99" a scan of a stream, else refused
  std::vector<std::string> lines;  ///< behind the status

  bool done() const { return status == "00"; }
  std::string command() const { return echo.substr(0, 2); }
};

/// @param tag  a request's ";text", sent back with the echo; may be empty.
Bytes encode_reply(const Reply& reply, const std::string& tag = "");

/// Parses a stream into replies, however it is split. Drops a reply with any bad checksum.
class ReplyParser {
 public:
  void push(std::span<const uint8_t> bytes);
  std::optional<Reply> next();
  std::size_t bytes_after() const { return buffer_.size() - head_; }  ///< behind the last reply
  void clear();

  int64_t garbage_bytes() const { return garbage_bytes_; }  ///< including dropped replies
  int64_t bad_checksums() const { return bad_checksums_; }

 private:
  std::optional<Reply> finish();

  std::string buffer_;
  std::size_t head_ = 0;
  std::vector<std::string> lines_;  ///< of the reply under way
  std::size_t bytes_ = 0;           ///< in them
  int64_t garbage_bytes_ = 0;
  int64_t bad_checksums_ = 0;
};

/// A request for scans: G. or H. (one), M. or N. (a stream); H and N with all echoes of a step.
struct ScanRequest {
  bool stream = true;
  int characters = 3;  ///< a value: 3 (D) or 2 (S, up to 4095 mm)
  int first_step = 0;
  int last_step = 0;
  int cluster = 1;           ///< steps merged to one value
  int skip = 0;              ///< turns left out between two scans of a stream
  int count = 0;             ///< scans of a stream; 0 = until QT
  bool intensities = false;  ///< E: each distance followed by its intensity, 3 characters each
  bool all_echoes = false;   ///< further echoes of a step follow its first, each behind a '&'

  std::string line() const;
  /// How many values a scan has.
  int values() const { return (last_step - first_step) / (cluster > 0 ? cluster : 1) + 1; }
};
std::optional<ScanRequest> parse_scan_request(std::string_view line);

/// The content of a scan.
struct Measurement {
  uint32_t timestamp_ms = 0;  ///< of the laser's clock, 24 bits
  std::vector<uint32_t> values_mm;
  std::vector<uint32_t> intensities;  ///< one a value where asked for, else empty
};
Reply encode_measurement(const ScanRequest& request, int remaining, const Measurement& scan);
/// @returns nothing when the reply does not match the request exactly, or has more than one echo of
/// a step.
std::optional<Measurement> decode_measurement(const Reply& reply, const ScanRequest& request);

/// A laser's reply to PP.
struct Parameters {
  std::string model = "URG-04LX(Hokuyo Automatic Co.,Ltd.)";
  int range_min_mm = 20;    ///< DMIN; smaller values are error codes
  int range_max_mm = 5600;  ///< DMAX
  int steps_per_turn = 1024;
  int first_step = 44;
  int last_step = 725;
  int front_step = 384;
  int rpm = 600;
};
Reply encode_parameters(const Parameters& parameters);
std::optional<Parameters> decode_parameters(const Reply& reply);

/// "KEY:value;" for the replies of VV, PP and II.
std::string key_line(const std::string& key, const std::string& value);

}  // namespace marco::drivers::hokuyo
