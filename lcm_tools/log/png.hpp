#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace marco::logs {

enum class PngSize {
  as_pixels,  ///< not compressed: it keeps pace with a camera
  small       ///< by zlib's quickest level, which suits maps
};

/// A PNG file of 8-bit pixels, gray (1 byte) or red, green, blue (3 bytes), row by row from the
/// top.
/// @param pixels whole rows of `width_px` pixels
/// @throws std::invalid_argument for anything else
std::string to_png(std::span<const uint8_t> pixels,
                   int width_px,
                   int pixel_bytes,
                   PngSize size = PngSize::as_pixels);

}  // namespace marco::logs
