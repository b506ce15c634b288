#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/transport/unread_bytes.hpp"

/// Telegrams of the SICK LMS 200/211/220/221/291/209 ("LMS2xx") laser scanners.
///
///     02 | address | length u16 | code, data ... [status, from the laser] | CRC u16
///
/// little endian; `length` counts code, data and status. The laser adds 80 to the address and to
/// the code it answers. Between telegrams a single 06 says "received", 15 "received damaged".
namespace marco::drivers::sick {

using Bytes = std::vector<uint8_t>;

inline constexpr uint8_t kStx = 0x02;
inline constexpr uint8_t kAck = 0x06;
inline constexpr uint8_t kNak = 0x15;
inline constexpr uint8_t kHealthy = 0x10;  ///< status byte: family LMS, no complaint

/// Codes of requests; the reply's is this | 0x80.
inline constexpr uint8_t kReset = 0x10;
inline constexpr uint8_t kSetMode = 0x20;
inline constexpr uint8_t kGetValues = 0x30;
inline constexpr uint8_t kGetStatus = 0x31;
inline constexpr uint8_t kGetErrors = 0x32;
inline constexpr uint8_t kGetMean = 0x36;  ///< one reply of a stream of the same kind
inline constexpr uint8_t kGetSubRange = 0x37;
inline constexpr uint8_t kGetType = 0x3A;
inline constexpr uint8_t kGetMeanSubRange = 0x3F;
inline constexpr uint8_t kSetVariant = 0x3B;
inline constexpr uint8_t kGetConfiguration = 0x74;
inline constexpr uint8_t kSetConfiguration = 0x77;
inline constexpr uint8_t kPowerOnReply = 0x90;
inline constexpr uint8_t kResetReply = 0x91;
inline constexpr uint8_t kRejectedReply = 0x92;
inline constexpr uint8_t kValuesReply = 0xB0;
inline constexpr uint8_t kMeanReply = 0xB6;
inline constexpr uint8_t kSubRangeReply = 0xB7;
inline constexpr uint8_t kMeanSubRangeReply = 0xBF;
inline constexpr uint8_t kReflectivityReply = 0xC4;
/// Whether decode_values can read replies of this code.
bool carries_values(uint8_t code);

/// Arguments of kSetMode.
using Mode = uint8_t;
inline constexpr uint8_t kInstallation = 0x00;
inline constexpr uint8_t kDiagnosis = 0x10;
inline constexpr uint8_t kContinuous = 0x24;
inline constexpr uint8_t kOnRequest = 0x25;
inline constexpr uint8_t kMean = 0x26;          ///< + number of scans
inline constexpr uint8_t kSubRange = 0x27;      ///< + first, last u16, from 1
inline constexpr uint8_t kMeanSubRange = 0x28;  ///< + number of scans, first, last
inline constexpr uint8_t kPartialScans = 0x2A;
inline constexpr uint8_t kReflectivity = 0x50;  ///< + first, last; "fast" models only
inline constexpr uint8_t kBaud38400 = 0x40;
inline constexpr uint8_t kBaud19200 = 0x41;
inline constexpr uint8_t kBaud9600 = 0x42;
inline constexpr uint8_t kBaud500000 = 0x48;
std::optional<Mode> mode_of_baud(int baud);
std::optional<int> baud_of_mode(uint8_t mode);

/// The laser's own cyclic code: one shift a byte, polynomial 8005, mixed with the last two bytes.
/// Not a standard CRC.
uint16_t crc(std::span<const uint8_t> bytes);

/// A whole telegram. @param payload  code, data and (from the laser) status; at least one byte.
Bytes encode_telegram(uint8_t address, std::span<const uint8_t> payload);
/// A request to any laser on the line.
Bytes encode_request(std::span<const uint8_t> payload);
/// A reply: status is appended to `payload`.
Bytes encode_reply(std::span<const uint8_t> payload,
                   uint8_t status = kHealthy,
                   uint8_t address = 0x80);

Bytes set_mode_request(Mode mode);
/// @param password  eight characters.
Bytes installation_request(const std::string& password = "SICK_LMS");
/// @param resolution_cdeg  of a degree's hundredths: 100, 50 or 25.
Bytes set_variant_request(int angle_deg, int resolution_cdeg);

/// One telegram, or one byte between telegrams.
struct Event {
  enum class Kind { telegram, ack, nak, bad_checksum };
  Kind kind = Kind::telegram;
  uint8_t address = 0;
  std::span<const uint8_t> payload;  ///< code first; valid until the parser's next call
  std::size_t bytes_total = 0;       ///< of the telegram on the line
  std::size_t bytes_after = 0;       ///< pushed already, behind it

  uint8_t code() const { return payload[0]; }
  uint8_t status() const { return payload.back(); }
  /// Between code and status.
  std::span<const uint8_t> data() const { return payload.subspan(1, payload.size() - 2); }
};

/// Parses a stream into telegrams, however it is split. Bytes that fit no telegram are skipped and
/// counted one by one, so that the next whole telegram after damage is found, even inside a false
/// one. Never delivers a telegram with a wrong CRC.
class TelegramParser : public UnreadParser {
 public:
  enum class Side { laser, host };  ///< the sender of the telegrams

  explicit TelegramParser(Side side) : side_(side) {}

  /// The next event within what was pushed.
  std::optional<Event> next();
  /// The line fell silent: gives up the incomplete telegram.
  void give_up_waiting();
  bool waiting() const { return !unread_.empty(); }

  int64_t bad_checksums() const { return bad_checksums_; }

 private:
  enum class Look { telegram, incomplete, nonsense };
  Look look(std::span<const uint8_t> from_stx) const;
  bool plausible(std::span<const uint8_t> header) const;

  Side side_;
  int64_t bad_checksums_ = 0;
};

enum class Unit : uint8_t { cm = 0, mm = 1, dm = 2 };
double metres(Unit unit);

/// How to read a value word in a measuring mode (byte 5 of the configuration).
struct RangeRule {
  uint16_t distance_mask;  ///< the other bits are fields or a reflector's level
  uint16_t first_special;  ///< from here on the distance is a code: see Special
};
/// @throws std::invalid_argument for a mode without distances.
RangeRule range_rule(int measuring_mode);

/// Codes at the top of the distance: their distance below the mask's all-ones.
enum class Special { no_echo, dazzled, overflow, noise, read_error, beyond_range, unknown };
/// @returns nothing for a distance.
std::optional<Special> special_of(uint16_t word, const RangeRule& rule);
uint16_t word_of(Special special, const RangeRule& rule);

/// The replies B0, B7 of a sub-range, B6 and BF of means, C4 with reflectivities.
struct MeasuredValues {
  Unit unit = Unit::cm;
  bool partial = false;             ///< one turn of an interlaced scan, not all of it
  int partial_offset_quarters = 0;  ///< its shift, quarters of a degree
  std::vector<uint16_t> words;      ///< right to left (counter-clockwise)
  std::vector<uint8_t> indices;     ///< real-time and telegram index, when switched on: 0 or 2
  std::optional<std::array<uint16_t, 2>> sub_range;  ///< first and last, from 1: makes it a B7
  uint8_t samples = 0;  ///< scans averaged: makes it a B6, with a sub-range a BF
  Bytes reflectivity;   ///< of the sub-range, one a value; not empty = a C4 with all the values
};
Bytes encode_values(const MeasuredValues& values);  ///< payload without status
std::optional<MeasuredValues> decode_values(const Event& reply);

/// The configuration block, as read (34 bytes; 32 on old firmware). All but three bytes are passed
/// through untouched.
struct Configuration {
  Bytes bytes = Bytes(34, 0);

  uint8_t availability() const { return bytes[4]; }
  int measuring_mode() const { return bytes[5]; }
  Unit unit() const { return static_cast<Unit>(bytes[6]); }
  void set_measuring(int mode, Unit unit) {
    bytes[5] = static_cast<uint8_t>(mode);
    bytes[6] = static_cast<uint8_t>(unit);
  }
  bool operator==(const Configuration&) const = default;
};
Bytes set_configuration_request(const Configuration& configuration);
/// Of the reply F4. @returns nothing when it is too short.
std::optional<Configuration> decode_configuration(const Event& reply);

/// The fields of the status block (reply B1) that we use.
struct StatusReport {
  std::string firmware;
  std::string boot_firmware;
  uint8_t mode = kOnRequest;
  bool defect = false;
  uint8_t variant_type = 0;
  std::array<uint16_t, 8> pollution{};
  std::array<uint16_t, 4> reference_pollution{};
  std::array<uint16_t, 8> pollution_calibration{};
  std::array<uint16_t, 4> reference_calibration{};
  int motor_revolutions = 0;
  int measuring_mode = 0;
  int angle_deg = 180;
  int resolution_cdeg = 100;
  int baud = 9600;  ///< 0 = a word we do not know
  bool permanent_baud = false;
  uint8_t address = 0;
  Unit unit = Unit::cm;
  uint8_t restart_mode = 0;
  uint8_t evaluations = 0;
  uint8_t field_set = 0;
  bool laser_on = false;
};
Bytes encode_status(const StatusReport& report);  ///< payload without status byte, 153 bytes
/// Both layouts, of 152 and of 146 bytes.
std::optional<StatusReport> decode_status(const Event& reply);

/// For a person: "error, pollution".
std::string describe_status_byte(uint8_t status);

/// The number of values in a scan of this variant; 0 when the laser has no such variant.
int beams_of_variant(int angle_deg, int resolution_cdeg);

}  // namespace marco::drivers::sick
