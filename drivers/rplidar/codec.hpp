#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/transport/unread_bytes.hpp"

/// Slamtec RPLIDAR A, C and S: nodes, express, dense, ultra and ultra dense capsules (of A3, C1 and
/// S no device was at hand): requests A5 command [length data xor]; answers begin with a descriptor
/// A5 5A, length and kind, followed by one block of data or by an endless stream of blocks.
namespace marco::drivers::rplidar {

using Bytes = std::vector<uint8_t>;

inline constexpr uint8_t kSync = 0xA5;   ///< begins a request and an answer
inline constexpr uint8_t kSync2 = 0x5A;  ///< behind it in an answer

inline constexpr uint8_t kStop = 0x25;
inline constexpr uint8_t kReset = 0x40;
inline constexpr uint8_t kScan = 0x20;
inline constexpr uint8_t kForceScan = 0x21;
inline constexpr uint8_t kGetInfo = 0x50;
inline constexpr uint8_t kGetHealth = 0x52;
inline constexpr uint8_t kGetSampleRate = 0x59;
inline constexpr uint8_t kExpressScan = 0x82;
inline constexpr uint8_t kGetConfiguration = 0x84;
inline constexpr uint8_t kSetMotorSpeed = 0xA8;  ///< turns a minute: S1 to S3
inline constexpr uint8_t kSetMotorPwm = 0xF0;
inline constexpr uint8_t kGetAccessoryFlag = 0xFF;

/// Kinds of data in a descriptor.
inline constexpr uint8_t kInfo = 0x04;
inline constexpr uint8_t kHealth = 0x06;
inline constexpr uint8_t kSampleRate = 0x15;
inline constexpr uint8_t kConfiguration = 0x20;
inline constexpr uint8_t kNodes = 0x81;
inline constexpr uint8_t kCapsules = 0x82;
inline constexpr uint8_t kUltraCapsules = 0x84;
inline constexpr uint8_t kDenseCapsules = 0x85;
inline constexpr uint8_t kUltraDenseCapsules = 0x86;
inline constexpr uint8_t kAccessoryFlag = 0xFF;

/// Keys of kGetConfiguration.
inline constexpr uint8_t kModeSamplePeriod = 0x71;  ///< of a mode: u32, us / 256
inline constexpr uint8_t kModeMaxRange = 0x74;      ///< of a mode: u32, m / 256
inline constexpr uint8_t kModeAnswer = 0x75;        ///< of a mode: u8, a kind above
inline constexpr uint8_t kTypicalMode = 0x7C;       ///< u16

inline constexpr std::size_t kNodeSize = 5;
inline constexpr std::size_t kCapsuleSize = 84;
inline constexpr int kCapsuleSamples = 32;
inline constexpr int kDenseSamples = 40;
inline constexpr int kUltraDenseSamples = 64;
inline constexpr int kUltraSamples = 96;
inline constexpr int kUltraCabins = 32;
inline constexpr int kTurnQ6 = 360 * 64;

Bytes encode_request(uint8_t command, std::span<const uint8_t> data = {});
Bytes motor_request(int pwm);
Bytes motor_speed_request(int turns_per_minute);
/// @param mode  nothing for a key that is no mode's
Bytes configuration_request(uint8_t key, std::optional<int> mode);
Bytes encode_descriptor(uint32_t length, bool stream, uint8_t kind);

struct Request {
  uint8_t command = 0;
  Bytes data;
};

/// Parses a host's requests, for the emulator.
class RequestParser : public UnreadParser {
 public:
  std::optional<Request> next();
};

struct Node {
  bool first = false;  ///< of a turn
  int quality = 0;
  int angle_q6 = 0;     ///< clockwise from ahead, 1/64 deg
  int distance_q2 = 0;  ///< 1/4 mm; 0 = none
  bool operator==(const Node&) const = default;
};
std::array<uint8_t, kNodeSize> encode_node(const Node& node);
/// @returns nothing when one of the three check bits is wrong or the angle beyond a turn.
std::optional<Node> decode_node(std::span<const uint8_t, kNodeSize> bytes);

struct Capsule {
  bool first = false;             ///< after the start of the scan
  int start_q6 = 0;               ///< angle of its first sample, 1/64 deg
  int samples = kCapsuleSamples;  ///< or kDenseSamples, kUltraSamples, kUltraDenseSamples
  std::array<int, kUltraDenseSamples> distance_mm{};
  std::array<int, kCapsuleSamples> offset_q3{};  ///< 1/8 deg, 0..63, against the turning
  std::array<uint32_t, kUltraCabins> cabins{};   ///< of an ultra capsule, instead of the two above
  bool operator==(const Capsule&) const = default;
};
std::array<uint8_t, kCapsuleSize> encode_capsule(const Capsule& capsule);
/// @returns nothing when the marks or the checksum are wrong.
std::optional<Capsule> decode_capsule(std::span<const uint8_t, kCapsuleSize> bytes);

/// Dense capsules: u16 mm each, up to 65 m, no offsets.
std::array<uint8_t, kCapsuleSize> encode_dense_capsule(const Capsule& capsule);
std::optional<Capsule> decode_dense_capsule(std::span<const uint8_t, kCapsuleSize> bytes);

/// Sets the two marks in front of a capsule, which hold the sum of the rest.
void mark_capsule(std::span<uint8_t> bytes);
bool is_marked_capsule(std::span<const uint8_t> bytes);

struct PlacedSample {
  double angle_deg = 0.0;  ///< [0..360), clockwise from ahead
  int range_mm = 0;        ///< 0 = none
};
/// The samples of a capsule, known only when the next has come.
/// @returns as many as `capsule.samples`.
std::vector<PlacedSample> samples_of(const Capsule& capsule, const Capsule& next);

/// Whether blocks of this kind are capsules of a stream.
bool are_capsules(uint8_t kind);
/// Bytes. @param kind  one of those that are_capsules()
std::size_t capsule_size(uint8_t kind);
int capsule_samples(uint8_t kind);

/// One block of an answer.
struct Block {
  uint8_t kind = 0;
  bool continuous = true;       ///< no bytes were skipped since the last block
  Bytes data;                   ///< of one answer
  Node node;                    ///< kind kNodes
  Capsule capsule;              ///< of the kinds that are_capsules()
  std::size_t bytes_after = 0;  ///< pushed already, behind it
};

/// Parses a laser's answers into blocks, however they are split. Resynchronizes by the checksum of
/// a capsule. Nodes have none: a node counts only if another one follows at a plausible angle.
class AnswerParser : public UnreadParser {
 public:
  std::optional<Block> next();
  /// A new request was sent: its answer begins with a descriptor.
  void expect_descriptor();
  bool streaming() const { return streaming_; }

  int64_t bad_checksums() const { return bad_checksums_; }

 private:
  bool read_descriptor();
  std::optional<Block> next_node();
  std::optional<Block> next_capsule();
  void skip(std::size_t count);

  bool in_answer_ = false;
  bool streaming_ = false;
  bool continuous_ = true;
  std::size_t length_ = 0;
  uint8_t kind_ = 0;
  int64_t bad_checksums_ = 0;
};

}  // namespace marco::drivers::rplidar
