#include "drivers/rplidar/ultra_dense_capsule.hpp"

#include <algorithm>

#include "drivers/transport/little_endian.hpp"

namespace marco::drivers::rplidar {
namespace {

// In front of the cabins: two marks, a u32 time stamp, a u16 status, the angle.
constexpr std::size_t kAngleAt = 8, kCabinsAt = 10, kCabinSize = 5;
constexpr uint32_t kStrength = 63;  // of every return that is encoded

/// The two lowest bits of a sample name its band; the range's steps and the strength follow.
struct Scale {
  int first_mm;
  int step_mm;
  unsigned bits;  ///< of the range
};
constexpr std::array<Scale, 4> kScales{{{0, 2, 10}, {2046, 3, 11}, {8187, 4, 12}, {24567, 5, 13}}};

uint32_t word_of(int range_mm) {
  if (range_mm <= 0) return 0;
  std::size_t band = kScales.size() - 1;
  while (range_mm < kScales[band].first_mm) --band;
  const auto [first_mm, step_mm, bits] = kScales[band];
  const int steps =
      std::min((range_mm - first_mm + step_mm / 2) / step_mm, static_cast<int>(1U << bits) - 1);
  return kStrength >> band << (2 + bits) | static_cast<uint32_t>(steps) << 2U |
         static_cast<uint32_t>(band);
}

int range_mm_of(uint32_t word) {
  const auto [first_mm, step_mm, bits] = kScales[word & 3U];
  return first_mm + step_mm * static_cast<int>(word >> 2U & ((1U << bits) - 1U));
}

}  // namespace

std::array<uint8_t, kUltraDenseCapsuleSize> encode_ultra_dense_capsule(const Capsule& capsule) {
  std::array<uint8_t, kUltraDenseCapsuleSize> bytes{};
  set_u16(bytes, kAngleAt, static_cast<unsigned>(capsule.start_q6 | (capsule.first ? 0x8000 : 0)));
  for (std::size_t i = 0; i < kUltraDenseSamples / 2; ++i) {
    const uint32_t one = word_of(capsule.distance_mm[2 * i]);
    const uint32_t two = word_of(capsule.distance_mm[2 * i + 1]);
    const std::size_t at = kCabinsAt + kCabinSize * i;
    set_u16(bytes, at, one & 0xFFFFU);
    set_u16(bytes, at + 2, two & 0xFFFFU);
    bytes[at + 4] = static_cast<uint8_t>(one >> 16U | two >> 16U << 4U);
  }
  mark_capsule(bytes);
  return bytes;
}

std::optional<Capsule> decode_ultra_dense_capsule(
    std::span<const uint8_t, kUltraDenseCapsuleSize> bytes) {
  if (!is_marked_capsule(bytes)) return std::nullopt;
  Capsule capsule;
  capsule.samples = kUltraDenseSamples;
  capsule.first = (get_u16(bytes, kAngleAt) & 0x8000) != 0;
  capsule.start_q6 = get_u16(bytes, kAngleAt) & 0x7FFF;
  for (std::size_t i = 0; i < kUltraDenseSamples / 2; ++i) {
    const std::size_t at = kCabinsAt + kCabinSize * i;
    const uint32_t high = bytes[at + 4];
    capsule.distance_mm[2 * i] =
        range_mm_of(static_cast<uint32_t>(get_u16(bytes, at)) | (high & 15U) << 16U);
    capsule.distance_mm[2 * i + 1] =
        range_mm_of(static_cast<uint32_t>(get_u16(bytes, at + 2)) | high >> 4U << 16U);
  }
  return capsule;
}

}  // namespace marco::drivers::rplidar
