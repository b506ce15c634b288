#include "drivers/rplidar/ultra_capsule.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/transport/little_endian.hpp"

namespace marco::drivers::rplidar {
namespace {

constexpr int kNone = -512, kNoneToo = 511;  // of a difference

/// A range of 12 bits, finer when it is near.
struct Scaled {
  int mm = 0;
  int level = 0;  ///< differences to it count in steps of 2^level
};
struct Band {
  int first_code;
  int first_mm;
  int level;
};
constexpr std::array<Band, 5> kBands{
    {{3328, 16384, 4}, {1792, 4096, 3}, {1280, 2048, 2}, {512, 512, 1}, {0, 0, 0}}};

Scaled unscale(int code) {
  for (const Band& band : kBands) {
    if (code < band.first_code) continue;
    return {band.first_mm + ((code - band.first_code) << band.level), band.level};
  }
  return {};
}

int scale(int mm) {
  for (const Band& band : kBands) {
    if (mm < band.first_mm) continue;
    const int half = (1 << band.level) / 2;
    return std::min(4095, band.first_code + ((mm - band.first_mm + half) >> band.level));
  }
  return 0;
}

/// Ten bits with a sign.
int difference_at(uint32_t cabin, unsigned bit) {
  const auto value = static_cast<int>(cabin >> bit & 0x3FFU);
  return (value & 0x200) != 0 ? value - 0x400 : value;
}

int range_by(const Scaled& base, int difference) {
  if (difference == kNone || difference == kNoneToo) return 0;
  return std::max(0, base.mm + difference * (1 << base.level));
}

uint32_t difference_to(const Scaled& base, int mm) {
  const auto steps = static_cast<int>(std::lround(std::ldexp(mm - base.mm, -base.level)));
  const bool told = mm > 0 && steps > kNone && steps < kNoneToo;
  return static_cast<uint32_t>(told ? steps : kNone) & 0x3FFU;
}

/// Of the second sample of a cabin.
const Scaled& base_of(const Scaled& own, const Scaled& behind) {
  return own.mm == 0 && behind.mm != 0 ? behind : own;
}

}  // namespace

std::array<uint8_t, kUltraCapsuleSize> encode_ultra_capsule(const Capsule& capsule) {
  std::array<uint8_t, kUltraCapsuleSize> bytes{};
  set_u16(bytes, 2, static_cast<unsigned>(capsule.start_q6 | (capsule.first ? 0x8000 : 0)));
  for (std::size_t i = 0; i < kUltraCabins; ++i) {
    set_u16(bytes, 4 + 4 * i, capsule.cabins[i] & 0xFFFFU);
    set_u16(bytes, 6 + 4 * i, capsule.cabins[i] >> 16U);
  }
  mark_capsule(bytes);
  return bytes;
}

std::optional<Capsule> decode_ultra_capsule(std::span<const uint8_t, kUltraCapsuleSize> bytes) {
  if (!is_marked_capsule(bytes)) return std::nullopt;
  Capsule capsule;
  capsule.samples = kUltraSamples;
  capsule.first = (get_u16(bytes, 2) & 0x8000) != 0;
  capsule.start_q6 = get_u16(bytes, 2) & 0x7FFF;
  for (std::size_t i = 0; i < kUltraCabins; ++i) {
    capsule.cabins[i] = static_cast<uint32_t>(get_u16(bytes, 4 + 4 * i)) |
                        static_cast<uint32_t>(get_u16(bytes, 6 + 4 * i)) << 16U;
  }
  return capsule;
}

void set_ultra_ranges(Capsule& capsule,
                      std::span<const int, kUltraSamples> ranges_mm,
                      int next_mm) {
  capsule.samples = kUltraSamples;
  for (std::size_t i = 0; i < kUltraCabins; ++i) {
    const int code = scale(ranges_mm[3 * i]);
    const bool last = i + 1 == kUltraCabins;
    const Scaled own = unscale(code);
    const Scaled behind = unscale(scale(last ? next_mm : ranges_mm[3 * i + 3]));
    capsule.cabins[i] = static_cast<uint32_t>(code) |
                        difference_to(base_of(own, behind), ranges_mm[3 * i + 1]) << 12U |
                        difference_to(behind, ranges_mm[3 * i + 2]) << 22U;
  }
}

std::array<int, kUltraSamples> ultra_ranges_mm(const Capsule& capsule, const Capsule& next) {
  std::array<int, kUltraSamples> ranges_mm{};
  for (std::size_t i = 0; i < kUltraCabins; ++i) {
    const uint32_t cabin = capsule.cabins[i];
    const uint32_t after = i + 1 < kUltraCabins ? capsule.cabins[i + 1] : next.cabins[0];
    const Scaled own = unscale(static_cast<int>(cabin & 0xFFFU));
    const Scaled behind = unscale(static_cast<int>(after & 0xFFFU));
    ranges_mm[3 * i] = own.mm;
    ranges_mm[3 * i + 1] = range_by(base_of(own, behind), difference_at(cabin, 12));
    ranges_mm[3 * i + 2] = range_by(behind, difference_at(cabin, 22));
  }
  return ranges_mm;
}

double ultra_offset_deg(int range_mm) {
  if (range_mm < 50) return 7.5;
  // In 1/65536 rad, in whole numbers as the maker's.
  constexpr auto kFarOff = static_cast<int64_t>(8.0 * std::numbers::pi * 65536.0 / 180.0);
  const int64_t near = 98361 / (4 * int64_t{range_mm});
  const int64_t offset = kFarOff - 64 * near - near * near * near / 98304;
  return static_cast<double>(offset) / 65536.0 * 180.0 / std::numbers::pi;
}

std::vector<PlacedSample> samples_of(const Capsule& capsule, const Capsule& next) {
  const int span_q6 = ((next.start_q6 - capsule.start_q6) % kTurnQ6 + kTurnQ6) % kTurnQ6;
  const bool ultra = capsule.samples == kUltraSamples;
  std::array<int, kUltraSamples> ranges_mm{};
  if (ultra) ranges_mm = ultra_ranges_mm(capsule, next);
  std::vector<PlacedSample> samples;
  for (int k = 0; k < capsule.samples; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const int range_mm = ultra ? ranges_mm[i] : capsule.distance_mm[i];
    double offset_deg = 0.0;
    if (ultra) offset_deg = ultra_offset_deg(range_mm);
    if (capsule.samples == kCapsuleSamples) offset_deg = capsule.offset_q3[i] / 8.0;
    const double angle_deg = std::fmod(
        capsule.start_q6 / 64.0 + k * span_q6 / 64.0 / capsule.samples - offset_deg, 360.0);
    samples.push_back({angle_deg < 0.0 ? angle_deg + 360.0 : angle_deg, range_mm});
  }
  return samples;
}

}  // namespace marco::drivers::rplidar
