#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace marco::logs {

/// A PNG file of 8-bit pixels, gray (1 byte) or red, green, blue (3 bytes), row by row from the
/// top. Not compressed: it keeps pace with a camera.
/// @param pixels whole rows of `width_px` pixels
/// @throws std::invalid_argument for anything else
std::string to_png(std::span<const uint8_t> pixels, int width_px, int pixel_bytes);

}  // namespace marco::logs
