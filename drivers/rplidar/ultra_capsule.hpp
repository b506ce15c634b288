#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/rplidar/codec.hpp"

/// Ultra capsules, of an A3 and an S1: 32 cabins of three samples each. The second and third are
/// told by their difference to the first one's range, and to that of the cabin behind. After
/// Slamtec's SDK 2.1.0.
namespace marco::drivers::rplidar {

inline constexpr std::size_t kUltraCapsuleSize = 132;

std::array<uint8_t, kUltraCapsuleSize> encode_ultra_capsule(const Capsule& capsule);
/// @returns nothing when the marks or the checksum are wrong.
std::optional<Capsule> decode_ultra_capsule(std::span<const uint8_t, kUltraCapsuleSize> bytes);

/// Writes ranges into the cabins of a capsule; each is rounded to 1 mm below 0.5 m, up to 16 mm
/// beyond 16 m. One that differs too much from its neighbour becomes 0: none.
/// @param next_mm  first range of the capsule behind it
void set_ultra_ranges(Capsule& capsule, std::span<const int, kUltraSamples> ranges_mm, int next_mm);
/// Ranges [mm], 0 = none.
std::array<int, kUltraSamples> ultra_ranges_mm(const Capsule& capsule, const Capsule& next);

/// How far the spot that a sample measures lies behind its angle: the light and its receiver are
/// apart. [deg]
double ultra_offset_deg(int range_mm);

}  // namespace marco::drivers::rplidar
