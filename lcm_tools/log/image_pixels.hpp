#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bot_core/image_t.hpp"

namespace marco {

/// @returns 1 for grey, 3 for RGB and BGR, 0 for formats that are not plain pixels (MJPEG, others).
int bytes_per_pixel(const bot_core::image_t& image);

/// The pixels row by row from the top without padding, colours in the order red, green, blue:
/// width * height * bytes_per_pixel bytes.
/// @returns nothing when the format is not plain pixels, or there are fewer than width and height
/// demand. Sides up to 65536.
std::optional<std::vector<uint8_t>> plain_pixels(const bot_core::image_t& image);

}  // namespace marco
