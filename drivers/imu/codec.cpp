#include "drivers/imu/codec.hpp"

#include <algorithm>
#include <numeric>

namespace marco::drivers::imu {
namespace {

constexpr uint8_t kHead = 0x55;
constexpr uint8_t kFirstKind = 0x50, kLastKind = 0x5A;

uint8_t sum_of(std::span<const uint8_t> bytes) {
  return static_cast<uint8_t>(std::accumulate(bytes.begin(), bytes.end(), 0U) & 0xFF);
}

}  // namespace

Bytes encode_frame(const Frame& frame) {
  Bytes bytes{kHead, frame.kind};
  for (const int16_t value : frame.values) {
    const auto word = static_cast<uint16_t>(value);
    bytes.push_back(static_cast<uint8_t>(word & 0xFF));
    bytes.push_back(static_cast<uint8_t>(word >> 8));
  }
  bytes.push_back(sum_of(bytes));
  return bytes;
}

std::optional<Frame> FrameParser::next() {
  while (unread_.size() >= kFrameBytes) {
    const std::span<const uint8_t> bytes = unread_.rest().first(kFrameBytes);
    const bool sound = bytes[0] == kHead && bytes[1] >= kFirstKind && bytes[1] <= kLastKind &&
                       sum_of(bytes.first(kFrameBytes - 1)) == bytes[kFrameBytes - 1];
    if (!sound) {
      unread_.skip();
      continue;
    }
    Frame found;
    found.kind = bytes[1];
    for (std::size_t i = 0; i < 4; ++i) {
      found.values[i] = static_cast<int16_t>(bytes[2 + 2 * i] | bytes[3 + 2 * i] << 8);
    }
    unread_.take(kFrameBytes);
    return found;
  }
  return std::nullopt;
}

Bytes unlock_request() { return {0xFF, 0xAA, 0x69, 0x88, 0xB5}; }

Bytes set_request(Register which, uint16_t value) {
  return {0xFF, 0xAA, static_cast<uint8_t>(which), static_cast<uint8_t>(value & 0xFF),
          static_cast<uint8_t>(value >> 8)};
}

std::optional<uint16_t> rate_code(int rate_hz) {
  static constexpr std::array<std::array<int, 2>, 8> kRates{
      {{1, 3}, {2, 4}, {5, 5}, {10, 6}, {20, 7}, {50, 8}, {100, 9}, {200, 11}}};
  const auto* found = std::find_if(kRates.begin(), kRates.end(),
                                   [&](const auto& rate) { return rate[0] == rate_hz; });
  if (found == kRates.end()) return std::nullopt;
  return static_cast<uint16_t>((*found)[1]);
}

}  // namespace marco::drivers::imu
