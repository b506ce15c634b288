#include "drivers/rplidar/codec.hpp"

#include <algorithm>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::drivers::rplidar {
namespace {

constexpr uint8_t kSync = 0xA5;
constexpr uint8_t kSync2 = 0x5A;
constexpr std::size_t kDescriptorSize = 7;
constexpr std::size_t kMaxAnswer = 256;
constexpr int kTurnQ6 = 360 * 64;
// From a node to the next: a degree or so, seldom backwards by a hair.
constexpr int kMaxStepQ6 = 20 * 64;
constexpr int kMaxBackQ6 = 1 * 64;
// After damage: a false node passes one time in hundreds, three in a row never.
constexpr std::size_t kNodesToTrust = 4;

uint8_t xor_of(std::span<const uint8_t> bytes) {
  uint8_t sum = 0;
  for (const uint8_t byte : bytes) sum = static_cast<uint8_t>(sum ^ byte);
  return sum;
}

int u16(std::span<const uint8_t> bytes, std::size_t at) { return bytes[at] | bytes[at + 1] << 8; }

void put_u16(std::span<uint8_t> bytes, std::size_t at, int value) {
  bytes[at] = static_cast<uint8_t>(value);
  bytes[at + 1] = static_cast<uint8_t>(value >> 8);
}

/// The sum, half in each of the two marks of a capsule.
void mark(std::array<uint8_t, kCapsuleSize>& bytes) {
  const uint8_t sum = xor_of(std::span(bytes).subspan(2));
  bytes[0] = static_cast<uint8_t>(0xA0 | (sum & 15));
  bytes[1] = static_cast<uint8_t>(0x50 | sum >> 4);
}

bool is_marked(std::span<const uint8_t, kCapsuleSize> bytes) {
  return bytes[0] >> 4 == 0xA && bytes[1] >> 4 == 0x5 &&
         xor_of(bytes.subspan(2)) == ((bytes[0] & 15) | (bytes[1] & 15) << 4);
}

bool follows(const Node& node, const Node& next) {
  const int step_q6 = ((next.angle_q6 - node.angle_q6) % kTurnQ6 + kTurnQ6) % kTurnQ6;
  return step_q6 <= kMaxStepQ6 || step_q6 >= kTurnQ6 - kMaxBackQ6;
}

}  // namespace

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

void RequestParser::push(std::span<const uint8_t> bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<Request> RequestParser::next() {
  while (buffer_.size() >= 2) {
    if (buffer_[0] != kSync || buffer_[1] == kSync) {
      buffer_.erase(buffer_.begin());
      continue;
    }
    Request request{buffer_[1], {}};
    if (request.command < 0x80) {
      buffer_.erase(buffer_.begin(), buffer_.begin() + 2);
      return request;
    }
    if (buffer_.size() < 3) return std::nullopt;
    const std::size_t size = 4u + buffer_[2];
    if (buffer_.size() < size) return std::nullopt;
    const bool good = xor_of(std::span(buffer_).first(size)) == 0;
    if (!good) {
      buffer_.erase(buffer_.begin());
      continue;
    }
    request.data.assign(buffer_.begin() + 3,
                        buffer_.begin() + static_cast<std::ptrdiff_t>(size) - 1);
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(size));
    return request;
  }
  return std::nullopt;
}

std::array<uint8_t, kNodeSize> encode_node(const Node& node) {
  std::array<uint8_t, kNodeSize> bytes{};
  bytes[0] = static_cast<uint8_t>(node.quality << 2 | (node.first ? 1 : 2));
  put_u16(bytes, 1, node.angle_q6 << 1 | 1);
  put_u16(bytes, 3, node.distance_q2);
  return bytes;
}

std::optional<Node> decode_node(std::span<const uint8_t, kNodeSize> bytes) {
  const bool first = (bytes[0] & 1) != 0;
  if (first == ((bytes[0] & 2) != 0) || (bytes[1] & 1) == 0) return std::nullopt;
  Node node{first, bytes[0] >> 2, u16(bytes, 1) >> 1, u16(bytes, 3)};
  // An angle of exactly a turn, or a little more, is seen from real devices.
  if (node.angle_q6 >= kTurnQ6 + 64) return std::nullopt;
  return node;
}

std::array<uint8_t, kCapsuleSize> encode_capsule(const Capsule& capsule) {
  std::array<uint8_t, kCapsuleSize> bytes{};
  put_u16(bytes, 2, capsule.start_q6 | (capsule.first ? 0x8000 : 0));
  for (std::size_t cabin = 0; cabin < kCapsuleSamples / 2; ++cabin) {
    const int o1 = capsule.offset_q3[2 * cabin];
    const int o2 = capsule.offset_q3[2 * cabin + 1];
    const std::size_t at = 4 + 5 * cabin;
    put_u16(bytes, at, capsule.distance_mm[2 * cabin] << 2 | o1 >> 4);
    put_u16(bytes, at + 2, capsule.distance_mm[2 * cabin + 1] << 2 | o2 >> 4);
    bytes[at + 4] = static_cast<uint8_t>((o1 & 15) | (o2 & 15) << 4);
  }
  mark(bytes);
  return bytes;
}

std::optional<Capsule> decode_capsule(std::span<const uint8_t, kCapsuleSize> bytes) {
  if (!is_marked(bytes)) return std::nullopt;
  Capsule capsule;
  capsule.first = (u16(bytes, 2) & 0x8000) != 0;
  capsule.start_q6 = u16(bytes, 2) & 0x7FFF;
  for (std::size_t cabin = 0; cabin < kCapsuleSamples / 2; ++cabin) {
    const std::size_t at = 4 + 5 * cabin;
    capsule.distance_mm[2 * cabin] = u16(bytes, at) >> 2;
    capsule.distance_mm[2 * cabin + 1] = u16(bytes, at + 2) >> 2;
    capsule.offset_q3[2 * cabin] = (bytes[at] & 3) << 4 | (bytes[at + 4] & 15);
    capsule.offset_q3[2 * cabin + 1] = (bytes[at + 2] & 3) << 4 | bytes[at + 4] >> 4;
  }
  return capsule;
}

std::array<uint8_t, kCapsuleSize> encode_dense_capsule(const Capsule& capsule) {
  std::array<uint8_t, kCapsuleSize> bytes{};
  put_u16(bytes, 2, capsule.start_q6 | (capsule.first ? 0x8000 : 0));
  for (std::size_t i = 0; i < kDenseSamples; ++i) put_u16(bytes, 4 + 2 * i, capsule.distance_mm[i]);
  mark(bytes);
  return bytes;
}

std::optional<Capsule> decode_dense_capsule(std::span<const uint8_t, kCapsuleSize> bytes) {
  if (!is_marked(bytes)) return std::nullopt;
  Capsule capsule;
  capsule.samples = kDenseSamples;
  capsule.first = (u16(bytes, 2) & 0x8000) != 0;
  capsule.start_q6 = u16(bytes, 2) & 0x7FFF;
  for (std::size_t i = 0; i < kDenseSamples; ++i) capsule.distance_mm[i] = u16(bytes, 4 + 2 * i);
  return capsule;
}

double sample_angle_deg(const Capsule& capsule, const Capsule& next, int k) {
  const int span_q6 = ((next.start_q6 - capsule.start_q6) % kTurnQ6 + kTurnQ6) % kTurnQ6;
  const double angle_deg = capsule.start_q6 / 64.0 + k * span_q6 / 64.0 / capsule.samples -
                           capsule.offset_q3[static_cast<std::size_t>(k)] / 8.0;
  return angle_deg < 0.0 ? angle_deg + 360.0 : angle_deg >= 360.0 ? angle_deg - 360.0 : angle_deg;
}

void AnswerParser::push(std::span<const uint8_t> bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(head_));
  head_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void AnswerParser::expect_descriptor() {
  in_answer_ = streaming_ = false;
  continuous_ = true;
  buffer_.clear();
  head_ = 0;
}

void AnswerParser::skip(std::size_t count) {
  head_ += count;
  garbage_bytes_ += static_cast<int64_t>(count);
  continuous_ = false;
}

bool AnswerParser::read_descriptor() {
  while (head_ < buffer_.size()) {
    const auto bytes = rest();
    const bool begins = bytes[0] == kSync && (bytes.size() < 2 || bytes[1] == kSync2);
    if (begins && bytes.size() < kDescriptorSize) return false;
    if (begins) {
      const uint32_t word =
          static_cast<uint32_t>(u16(bytes, 2)) | static_cast<uint32_t>(u16(bytes, 4)) << 16;
      kind_ = bytes[6];
      length_ = word & 0x3FFFFFFF;
      streaming_ = word >> 30 == 1;
      const std::size_t stream_size = kind_ == kNodes ? kNodeSize : kCapsuleSize;
      const bool known_stream =
          (kind_ == kNodes || kind_ == kCapsules || kind_ == kDenseCapsules) &&
          length_ == stream_size;
      if (streaming_ ? known_stream : length_ > 0 && length_ <= kMaxAnswer) {
        head_ += kDescriptorSize;
        in_answer_ = continuous_ = true;
        return true;
      }
      streaming_ = false;
    }
    skip(1);
  }
  return false;
}

std::optional<Block> AnswerParser::next() {
  if (!in_answer_ && !read_descriptor()) return std::nullopt;
  if (streaming_) return kind_ == kNodes ? next_node() : next_capsule();
  if (rest().size() < length_) return std::nullopt;
  Block block;
  block.kind = kind_;
  block.data.assign(rest().begin(), rest().begin() + static_cast<std::ptrdiff_t>(length_));
  head_ += length_;
  block.bytes_after = rest().size();
  in_answer_ = false;
  return block;
}

std::optional<Block> AnswerParser::next_node() {
  while (true) {
    const std::size_t needed = continuous_ ? 2 : kNodesToTrust;
    if (rest().size() < needed * kNodeSize) return std::nullopt;
    const auto node = decode_node(rest().first<kNodeSize>());
    std::optional<Node> last = node;
    for (std::size_t i = 1; i < needed && last; ++i) {
      const auto after = decode_node(rest().subspan(i * kNodeSize).first<kNodeSize>());
      last = after && follows(*last, *after) ? after : std::nullopt;
    }
    if (!last) {
      skip(1);
      continue;
    }
    Block block;
    block.kind = kNodes;
    block.continuous = std::exchange(continuous_, true);
    block.node = *node;
    head_ += kNodeSize;
    block.bytes_after = rest().size();
    return block;
  }
}

std::optional<Block> AnswerParser::next_capsule() {
  while (rest().size() >= kCapsuleSize) {
    const auto bytes = rest().first<kCapsuleSize>();
    const auto capsule = kind_ == kCapsules ? decode_capsule(bytes) : decode_dense_capsule(bytes);
    if (!capsule) {
      bad_checksums_ += bytes[0] >> 4 == 0xA && bytes[1] >> 4 == 0x5 ? 1 : 0;
      skip(1);
      continue;
    }
    Block block;
    block.kind = kind_;
    block.continuous = std::exchange(continuous_, true);
    block.capsule = *capsule;
    head_ += kCapsuleSize;
    block.bytes_after = rest().size();
    return block;
  }
  return std::nullopt;
}

}  // namespace marco::drivers::rplidar
