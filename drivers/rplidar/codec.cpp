#include "drivers/rplidar/codec.hpp"

#include <utility>

#include "drivers/transport/little_endian.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::rplidar {
namespace {

uint8_t xor_of(std::span<const uint8_t> bytes) {
  uint8_t sum = 0;
  for (const uint8_t byte : bytes) sum = static_cast<uint8_t>(sum ^ byte);
  return sum;
}

}  // namespace

void mark_capsule(std::span<uint8_t> bytes) {
  const uint8_t sum = xor_of(bytes.subspan(2));
  bytes[0] = static_cast<uint8_t>(0xA0 | (sum & 15));
  bytes[1] = static_cast<uint8_t>(0x50 | sum >> 4);
}

bool is_marked_capsule(std::span<const uint8_t> bytes) {
  return bytes[0] >> 4 == 0xA && bytes[1] >> 4 == 0x5 &&
         xor_of(bytes.subspan(2)) == ((bytes[0] & 15) | (bytes[1] & 15) << 4);
}

Bytes encode_request(uint8_t command, std::span<const uint8_t> data) {
  Bytes request{kSync, command};
  if (data.empty()) return request;
  request.push_back(static_cast<uint8_t>(data.size()));
  request.insert(request.end(), data.begin(), data.end());
  request.push_back(xor_of(request));
  return request;
}

Bytes motor_request(int pwm) {
  require(pwm >= 0 && pwm <= 1023, "the motor's PWM lies within 0..1023");
  return encode_request(kSetMotorPwm,
                        Bytes{static_cast<uint8_t>(pwm), static_cast<uint8_t>(pwm >> 8)});
}

Bytes motor_speed_request(int turns_per_minute) {
  return encode_request(kSetMotorSpeed, Bytes{static_cast<uint8_t>(turns_per_minute),
                                              static_cast<uint8_t>(turns_per_minute >> 8)});
}

Bytes configuration_request(uint8_t key, std::optional<int> mode) {
  Bytes data{key, 0, 0, 0};
  if (mode) data.push_back(static_cast<uint8_t>(*mode));
  if (mode) data.push_back(static_cast<uint8_t>(*mode >> 8));
  return encode_request(kGetConfiguration, data);
}

Bytes encode_descriptor(uint32_t length, bool stream, uint8_t kind) {
  const uint32_t word = length | (stream ? 1u << 30 : 0u);
  return {kSync,
          kSync2,
          static_cast<uint8_t>(word),
          static_cast<uint8_t>(word >> 8),
          static_cast<uint8_t>(word >> 16),
          static_cast<uint8_t>(word >> 24),
          kind};
}

std::optional<Request> RequestParser::next() {
  while (unread_.size() >= 2) {
    const std::span<const uint8_t> rest = unread_.rest();
    if (rest[0] != kSync || rest[1] == kSync) {
      unread_.skip();
      continue;
    }
    Request request{rest[1], {}};
    if (request.command < 0x80) {
      unread_.take(2);
      return request;
    }
    if (rest.size() < 3) return std::nullopt;
    const std::size_t size = 4u + rest[2];
    if (rest.size() < size) return std::nullopt;
    if (xor_of(rest.first(size)) != 0) {
      unread_.skip();
      continue;
    }
    const auto data = rest.subspan(3, size - 4);
    request.data.assign(data.begin(), data.end());
    unread_.take(size);
    return request;
  }
  return std::nullopt;
}

std::array<uint8_t, kNodeSize> encode_node(const Node& node) {
  std::array<uint8_t, kNodeSize> bytes{};
  bytes[0] = static_cast<uint8_t>(node.quality << 2 | (node.first ? 1 : 2));
  set_u16(bytes, 1, node.angle_q6 << 1 | 1);
  set_u16(bytes, 3, node.distance_q2);
  return bytes;
}

std::optional<Node> decode_node(std::span<const uint8_t, kNodeSize> bytes) {
  const bool first = (bytes[0] & 1) != 0;
  if (first == ((bytes[0] & 2) != 0) || (bytes[1] & 1) == 0) return std::nullopt;
  Node node{first, bytes[0] >> 2, get_u16(bytes, 1) >> 1, get_u16(bytes, 3)};
  // An angle of exactly a turn, or a little more, is seen from real devices.
  if (node.angle_q6 >= kTurnQ6 + 64) return std::nullopt;
  return node;
}

std::array<uint8_t, kCapsuleSize> encode_capsule(const Capsule& capsule) {
  std::array<uint8_t, kCapsuleSize> bytes{};
  set_u16(bytes, 2, capsule.start_q6 | (capsule.first ? 0x8000 : 0));
  for (std::size_t cabin = 0; cabin < kCapsuleSamples / 2; ++cabin) {
    const int o1 = capsule.offset_q3[2 * cabin];
    const int o2 = capsule.offset_q3[2 * cabin + 1];
    const std::size_t at = 4 + 5 * cabin;
    set_u16(bytes, at, capsule.distance_mm[2 * cabin] << 2 | o1 >> 4);
    set_u16(bytes, at + 2, capsule.distance_mm[2 * cabin + 1] << 2 | o2 >> 4);
    bytes[at + 4] = static_cast<uint8_t>((o1 & 15) | (o2 & 15) << 4);
  }
  mark_capsule(bytes);
  return bytes;
}

std::optional<Capsule> decode_capsule(std::span<const uint8_t, kCapsuleSize> bytes) {
  if (!is_marked_capsule(bytes)) return std::nullopt;
  Capsule capsule;
  capsule.first = (get_u16(bytes, 2) & 0x8000) != 0;
  capsule.start_q6 = get_u16(bytes, 2) & 0x7FFF;
  for (std::size_t cabin = 0; cabin < kCapsuleSamples / 2; ++cabin) {
    const std::size_t at = 4 + 5 * cabin;
    capsule.distance_mm[2 * cabin] = get_u16(bytes, at) >> 2;
    capsule.distance_mm[2 * cabin + 1] = get_u16(bytes, at + 2) >> 2;
    capsule.offset_q3[2 * cabin] = (bytes[at] & 3) << 4 | (bytes[at + 4] & 15);
    capsule.offset_q3[2 * cabin + 1] = (bytes[at + 2] & 3) << 4 | bytes[at + 4] >> 4;
  }
  return capsule;
}

std::array<uint8_t, kCapsuleSize> encode_dense_capsule(const Capsule& capsule) {
  std::array<uint8_t, kCapsuleSize> bytes{};
  set_u16(bytes, 2, capsule.start_q6 | (capsule.first ? 0x8000 : 0));
  for (std::size_t i = 0; i < kDenseSamples; ++i) set_u16(bytes, 4 + 2 * i, capsule.distance_mm[i]);
  mark_capsule(bytes);
  return bytes;
}

std::optional<Capsule> decode_dense_capsule(std::span<const uint8_t, kCapsuleSize> bytes) {
  if (!is_marked_capsule(bytes)) return std::nullopt;
  Capsule capsule;
  capsule.samples = kDenseSamples;
  capsule.first = (get_u16(bytes, 2) & 0x8000) != 0;
  capsule.start_q6 = get_u16(bytes, 2) & 0x7FFF;
  for (std::size_t i = 0; i < kDenseSamples; ++i)
    capsule.distance_mm[i] = get_u16(bytes, 4 + 2 * i);
  return capsule;
}

}  // namespace marco::drivers::rplidar
