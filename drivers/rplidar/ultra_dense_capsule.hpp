#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/rplidar/codec.hpp"

/// Ultra dense capsules, of an S3 and of newer firmware: 64 samples in 32 cabins, each sample a
/// range whose steps grow with it and the strength of its return. No offsets, as in a dense
/// capsule. In no protocol document; after Slamtec's SDK, which also smooths ranges below two
/// metres.
namespace marco::drivers::rplidar {

inline constexpr std::size_t kUltraDenseCapsuleSize = 170;

/// Ranges are rounded to 2 mm up to 2.0 m, 3 mm to 8.2, 4 mm to 24.6, and 5 mm beyond; at most 65.5
/// m.
std::array<uint8_t, kUltraDenseCapsuleSize> encode_ultra_dense_capsule(const Capsule& capsule);
/// @returns nothing when the marks or the checksum are wrong.
std::optional<Capsule> decode_ultra_dense_capsule(
    std::span<const uint8_t, kUltraDenseCapsuleSize> bytes);

}  // namespace marco::drivers::rplidar
