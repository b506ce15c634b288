#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/transport/unread_bytes.hpp"

/// LDROBOT LD06, LD19 and STL27L: they only talk. Each packet holds twelve samples. From the
/// maker's LD06 manual and ldlidar_stl_ros2; no device was at hand. Not said by either: that the
/// stamp is the last sample's, and that the STL27L turns as the others do.
namespace marco::drivers::ldlidar {

using Bytes = std::vector<uint8_t>;

inline constexpr std::size_t kPacketSize = 47;
inline constexpr int kPacketSamples = 12;
inline constexpr int kStampWrapMs = 30'000;

struct Sample {
  int range_mm = 0;  ///< 0 = none
  int intensity = 0;
  bool operator==(const Sample&) const = default;
};

struct Packet {
  int speed_deg_per_s = 0;
  int start_cdeg = 0;  ///< of the first sample, clockwise from ahead, 1/100 deg
  int end_cdeg = 0;    ///< of the last one
  std::array<Sample, kPacketSamples> samples;
  int stamp_ms = 0;  ///< below kStampWrapMs; of the last sample
  bool operator==(const Packet&) const = default;
};

/// CRC of eight bits: polynomial 4D, initially 0, not reflected.
uint8_t crc8(std::span<const uint8_t> bytes);

std::array<uint8_t, kPacketSize> encode_packet(const Packet& packet);
/// @returns nothing when marks or CRC are wrong, or an angle is beyond a turn.
std::optional<Packet> decode_packet(std::span<const uint8_t, kPacketSize> bytes);

/// Angle of sample i [deg, 0..360), clockwise from ahead.
double sample_angle_deg(const Packet& packet, int i);

struct Received {
  Packet packet;
  bool continuous = true;       ///< no bytes were skipped since the last one
  std::size_t bytes_after = 0;  ///< pushed already, behind it
};

/// Finds packets however they are split, and again after damage.
class PacketParser : public UnreadParser {
 public:
  std::optional<Received> next();
  void clear();

  int64_t bad_checksums() const { return bad_checksums_; }

 private:
  bool continuous_ = true;
  int64_t bad_checksums_ = 0;
};

}  // namespace marco::drivers::ldlidar
