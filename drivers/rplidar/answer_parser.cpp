#include <utility>

#include "drivers/rplidar/codec.hpp"
#include "drivers/rplidar/ultra_capsule.hpp"
#include "drivers/rplidar/ultra_dense_capsule.hpp"
#include "drivers/transport/little_endian.hpp"

namespace marco::drivers::rplidar {
namespace {

constexpr std::size_t kDescriptorSize = 7;
constexpr std::size_t kMaxAnswer = 256;
// From a node to the next: a degree or so, seldom backwards by a hair.
constexpr int kMaxStepQ6 = 20 * 64;
constexpr int kMaxBackQ6 = 1 * 64;
// After damage: a false node passes one time in hundreds, three in a row never.
constexpr std::size_t kNodesToTrust = 4;

bool follows(const Node& node, const Node& next) {
  const int step_q6 = ((next.angle_q6 - node.angle_q6) % kTurnQ6 + kTurnQ6) % kTurnQ6;
  return step_q6 <= kMaxStepQ6 || step_q6 >= kTurnQ6 - kMaxBackQ6;
}

/// @param bytes  as many as capsule_size(kind) tells
std::optional<Capsule> decode_any_capsule(uint8_t kind, std::span<const uint8_t> bytes) {
  if (kind == kUltraCapsules) return decode_ultra_capsule(bytes.first<kUltraCapsuleSize>());
  if (kind == kUltraDenseCapsules) {
    return decode_ultra_dense_capsule(bytes.first<kUltraDenseCapsuleSize>());
  }
  const auto short_one = bytes.first<kCapsuleSize>();
  return kind == kCapsules ? decode_capsule(short_one) : decode_dense_capsule(short_one);
}

}  // namespace

bool are_capsules(uint8_t kind) {
  return kind == kCapsules || kind == kDenseCapsules || kind == kUltraCapsules ||
         kind == kUltraDenseCapsules;
}

std::size_t capsule_size(uint8_t kind) {
  if (kind == kUltraCapsules) return kUltraCapsuleSize;
  return kind == kUltraDenseCapsules ? kUltraDenseCapsuleSize : kCapsuleSize;
}

int capsule_samples(uint8_t kind) {
  if (kind == kUltraCapsules) return kUltraSamples;
  if (kind == kUltraDenseCapsules) return kUltraDenseSamples;
  return kind == kDenseCapsules ? kDenseSamples : kCapsuleSamples;
}

void AnswerParser::expect_descriptor() {
  in_answer_ = streaming_ = false;
  continuous_ = true;
  unread_.clear();
}

void AnswerParser::skip(std::size_t count) {
  unread_.skip(count);
  continuous_ = false;
}

bool AnswerParser::read_descriptor() {
  while (!unread_.empty()) {
    const auto bytes = rest();
    const bool begins = bytes[0] == kSync && (bytes.size() < 2 || bytes[1] == kSync2);
    if (begins && bytes.size() < kDescriptorSize) return false;
    if (begins) {
      const uint32_t word =
          static_cast<uint32_t>(get_u16(bytes, 2)) | static_cast<uint32_t>(get_u16(bytes, 4)) << 16;
      kind_ = bytes[6];
      length_ = word & 0x3FFFFFFF;
      streaming_ = word >> 30 == 1;
      const bool known_stream = (kind_ == kNodes && length_ == kNodeSize) ||
                                (are_capsules(kind_) && length_ == capsule_size(kind_));
      if (streaming_ ? known_stream : length_ > 0 && length_ <= kMaxAnswer) {
        unread_.take(kDescriptorSize);
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
  unread_.take(length_);
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
    unread_.take(kNodeSize);
    block.bytes_after = rest().size();
    return block;
  }
}

std::optional<Block> AnswerParser::next_capsule() {
  while (rest().size() >= length_) {
    const auto bytes = rest().first(length_);
    const auto capsule = decode_any_capsule(kind_, bytes);
    if (!capsule) {
      bad_checksums_ += bytes[0] >> 4 == 0xA && bytes[1] >> 4 == 0x5 ? 1 : 0;
      skip(1);
      continue;
    }
    Block block;
    block.kind = kind_;
    block.continuous = std::exchange(continuous_, true);
    block.capsule = *capsule;
    unread_.take(length_);
    block.bytes_after = rest().size();
    return block;
  }
  return std::nullopt;
}

}  // namespace marco::drivers::rplidar
