#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "lcm_tools/spy/picture.hpp"

namespace marco::spy {

/// Decodes a JPEG as gray at half its size, which is enough for a terminal. Also motion JPEG, whose
/// frames lack the Huffman tables.
/// @returns nothing when libjpeg cannot decode it, or above 2^26 pixels
std::optional<GrayImage> decode_jpeg(std::span<const uint8_t> bytes);

}  // namespace marco::spy
