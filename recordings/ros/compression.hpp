#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace marco::ros {

/// No chunk that a recorder writes is larger when it is unpacked.
inline constexpr uint64_t kMostPlainBytes = uint64_t{1} << 28;

/// The plain bytes of a chunk, as far as its compressed ones go: fewer than `plain_size` where
/// these are cut off or damaged, never more.
/// @param name  of ROS bags and MCAP: "", "none", "bz2", "lz4" (frames), "zstd"
/// @throws std::invalid_argument for another name, and for more than kMostPlainBytes.
std::vector<uint8_t> decompressed(std::string_view name,
                                  std::span<const uint8_t> bytes,
                                  uint64_t plain_size);

/// Of a zstd frame that need not say its size. @returns nothing where it is damaged or too large.
std::vector<uint8_t> decompressed_zstd(std::span<const uint8_t> frame);

/// Whether the bytes begin a zstd frame.
bool is_zstd(std::span<const uint8_t> bytes);

}  // namespace marco::ros
