#include "drivers/ydlidar/codec.hpp"

#include <cmath>
#include <numbers>

#include "drivers/transport/little_endian.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::ydlidar {
namespace {

constexpr int kTurnQ6 = 360 * 64;
constexpr std::size_t kKindAt = 2, kCountAt = 3, kFirstAt = 4, kLastAt = 6, kSumAt = 8;

// Exclusive or of the words; an intensity of one byte counts as a word.
unsigned sum_of(std::span<const uint8_t> bytes, SampleForm form) {
  unsigned sum = 0;
  for (std::size_t at = 0; at < kSumAt; at += 2) sum ^= get_u16(bytes, at);
  const std::size_t size = sample_size(form);
  for (std::size_t at = kPacketHeadSize; at < bytes.size(); at += size) {
    if (form == SampleForm::intensity) sum ^= bytes[at];
    if (form == SampleForm::wide_intensity) sum ^= get_u16(bytes, at);
    sum ^= get_u16(bytes, at + size - 2);
  }
  return sum;
}

unsigned angle_word(int angle_q6) { return static_cast<unsigned>(angle_q6) << 1U | 1U; }

}  // namespace

Bytes encode_request(uint8_t command) { return {kRequestMark, command}; }

Bytes encode_header(uint32_t length, bool stream, uint8_t kind) {
  const uint32_t word = length | (stream ? 1U << 30U : 0U);
  Bytes header;
  put_u16(header, kReplyMark);
  put_u16(header, word & 0xFFFFU);
  put_u16(header, word >> 16U);
  header.push_back(kind);
  return header;
}

std::size_t sample_size(SampleForm form) { return 2 + static_cast<std::size_t>(form); }

Bytes encode_packet(const Packet& packet, SampleForm form) {
  require(!packet.samples.empty() && packet.samples.size() <= kMaxSamples,
          "a YDLIDAR packet has 1 to 80 samples, not " + std::to_string(packet.samples.size()));
  Bytes bytes;
  put_u16(bytes, kPacketMark);
  bytes.push_back(static_cast<uint8_t>(packet.frequency_dhz << 1 | (packet.turn_start ? 1 : 0)));
  bytes.push_back(static_cast<uint8_t>(packet.samples.size()));
  put_u16(bytes, angle_word(packet.first_q6));
  put_u16(bytes, angle_word(packet.last_q6));
  put_u16(bytes, 0);
  for (const Sample& sample : packet.samples) {
    const auto intensity = static_cast<unsigned>(sample.intensity);
    const bool in_mm = form == SampleForm::wide_intensity;
    const auto range =
        static_cast<unsigned>(std::lround(in_mm ? sample.range_mm : 4.0 * sample.range_mm));
    if (form == SampleForm::intensity) bytes.push_back(static_cast<uint8_t>(intensity));
    if (form == SampleForm::wide_intensity) put_u16(bytes, intensity);
    put_u16(bytes, form == SampleForm::intensity ? range & ~3U : range);
  }
  set_u16(bytes, kSumAt, sum_of(bytes, form));
  return bytes;
}

std::optional<std::size_t> packet_size(std::span<const uint8_t> head, SampleForm form) {
  const int samples = head[kCountAt];
  if (get_u16(head, 0) != kPacketMark || samples < 1 || samples > kMaxSamples) return std::nullopt;
  for (const std::size_t at : {kFirstAt, kLastAt}) {
    if ((head[at] & 1U) == 0 || get_u16(head, at) >> 1 > kTurnQ6) return std::nullopt;
  }
  return kPacketHeadSize + static_cast<std::size_t>(samples) * sample_size(form);
}

std::optional<Packet> decode_packet(std::span<const uint8_t> bytes, SampleForm form) {
  if (sum_of(bytes, form) != get_u16(bytes, kSumAt)) return std::nullopt;
  Packet packet;
  packet.turn_start = (bytes[kKindAt] & 1U) != 0;
  packet.frequency_dhz = bytes[kKindAt] >> 1;
  packet.first_q6 = get_u16(bytes, kFirstAt) >> 1;
  packet.last_q6 = get_u16(bytes, kLastAt) >> 1;
  const std::size_t size = sample_size(form);
  for (std::size_t at = kPacketHeadSize; at < bytes.size(); at += size) {
    const unsigned range = get_u16(bytes, at + size - 2);
    Sample sample;
    sample.range_mm = range / 4.0;
    if (form == SampleForm::intensity) {
      sample = {(range & ~3U) / 4.0, bytes[at]};
    } else if (form == SampleForm::wide_intensity) {
      sample = {static_cast<double>(range), get_u16(bytes, at)};
    }
    packet.samples.push_back(sample);
  }
  return packet;
}

double sample_angle_deg(const Packet& packet, std::size_t i) {
  const int span_q6 = (packet.last_q6 - packet.first_q6 + kTurnQ6) % kTurnQ6;
  const auto steps = static_cast<double>(packet.samples.size() - 1);
  const double part = steps > 0.0 ? static_cast<double>(i) / steps : 0.0;
  const double angle_deg = (packet.first_q6 + part * span_q6) / 64.0;
  return angle_deg >= 360.0 ? angle_deg - 360.0 : angle_deg;
}

double angle_correction_deg(double range_mm) {
  constexpr double kBaseMm = 21.8, kFocusMm = 155.3;
  if (range_mm <= 0.0) return 0.0;
  return std::atan(kBaseMm * (kFocusMm - range_mm) / (kFocusMm * range_mm)) * 180.0 /
         std::numbers::pi;
}

DeviceInfo decode_info(std::span<const uint8_t> data) {
  return {data[0], data[2], data[1], data[3]};
}

std::string model_name(int model) {
  if (model == 5) return "G4";
  if (model == 6) return "X4";
  return "model " + std::to_string(model);
}

}  // namespace marco::drivers::ydlidar
