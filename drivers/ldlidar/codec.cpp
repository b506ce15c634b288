#include "drivers/ldlidar/codec.hpp"

#include <utility>

#include "drivers/transport/little_endian.hpp"

namespace marco::drivers::ldlidar {
namespace {

constexpr uint8_t kMark = 0x54;
constexpr uint8_t kKindAndCount = 0x2C;  // kind 1, twelve samples
constexpr int kTurnCdeg = 36'000;
constexpr std::size_t kSpeedAt = 2, kStartAt = 4, kSamplesAt = 6, kEndAt = 42, kStampAt = 44;
constexpr std::size_t kCrcAt = 46;
constexpr std::size_t kSampleSize = 3;

constexpr std::array<uint8_t, 256> crc_table() {
  std::array<uint8_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x80U) != 0 ? crc << 1U ^ 0x4DU : crc << 1U;
    table[byte] = static_cast<uint8_t>(crc);
  }
  return table;
}
constexpr std::array<uint8_t, 256> kCrcTable = crc_table();

bool begins_packet(std::span<const uint8_t> bytes) {
  return bytes[0] == kMark && (bytes.size() < 2 || bytes[1] == kKindAndCount);
}

}  // namespace

uint8_t crc8(std::span<const uint8_t> bytes) {
  uint8_t crc = 0;
  for (const uint8_t byte : bytes) crc = kCrcTable[crc ^ byte];
  return crc;
}

std::array<uint8_t, kPacketSize> encode_packet(const Packet& packet) {
  std::array<uint8_t, kPacketSize> bytes{kMark, kKindAndCount};
  set_u16(bytes, kSpeedAt, static_cast<unsigned>(packet.speed_deg_per_s));
  set_u16(bytes, kStartAt, static_cast<unsigned>(packet.start_cdeg));
  for (std::size_t i = 0; i < kPacketSamples; ++i) {
    const std::size_t at = kSamplesAt + kSampleSize * i;
    set_u16(bytes, at, static_cast<unsigned>(packet.samples[i].range_mm));
    bytes[at + 2] = static_cast<uint8_t>(packet.samples[i].intensity);
  }
  set_u16(bytes, kEndAt, static_cast<unsigned>(packet.end_cdeg));
  set_u16(bytes, kStampAt, static_cast<unsigned>(packet.stamp_ms));
  bytes[kCrcAt] = crc8(std::span(bytes).first<kCrcAt>());
  return bytes;
}

std::optional<Packet> decode_packet(std::span<const uint8_t, kPacketSize> bytes) {
  if (!begins_packet(bytes) || crc8(bytes.first<kCrcAt>()) != bytes[kCrcAt]) return std::nullopt;
  Packet packet;
  packet.speed_deg_per_s = get_u16(bytes, kSpeedAt);
  packet.start_cdeg = get_u16(bytes, kStartAt);
  packet.end_cdeg = get_u16(bytes, kEndAt);
  packet.stamp_ms = get_u16(bytes, kStampAt);
  for (std::size_t i = 0; i < kPacketSamples; ++i) {
    const std::size_t at = kSamplesAt + kSampleSize * i;
    packet.samples[i] = {get_u16(bytes, at), bytes[at + 2]};
  }
  if (packet.start_cdeg > kTurnCdeg || packet.end_cdeg > kTurnCdeg) return std::nullopt;
  return packet;
}

double sample_angle_deg(const Packet& packet, int i) {
  const int span_cdeg = (packet.end_cdeg - packet.start_cdeg + kTurnCdeg) % kTurnCdeg;
  const double angle_deg =
      (packet.start_cdeg + static_cast<double>(i * span_cdeg) / (kPacketSamples - 1)) / 100.0;
  return angle_deg >= 360.0 ? angle_deg - 360.0 : angle_deg;
}

void PacketParser::clear() {
  unread_.clear();
  continuous_ = false;
}

std::optional<Received> PacketParser::next() {
  while (!unread_.empty()) {
    const std::span<const uint8_t> rest = unread_.rest();
    const bool begins = begins_packet(rest);
    if (begins && rest.size() < kPacketSize) return std::nullopt;
    if (begins) {
      if (const auto packet = decode_packet(rest.first<kPacketSize>())) {
        unread_.take(kPacketSize);
        return Received{*packet, std::exchange(continuous_, true), rest.size() - kPacketSize};
      }
      ++bad_checksums_;
    }
    unread_.skip();
    continuous_ = false;
  }
  return std::nullopt;
}

}  // namespace marco::drivers::ldlidar
