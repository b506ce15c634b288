#include "lcm_tools/log/image_pixels.hpp"

#include <cstddef>
#include <utility>

namespace marco {
namespace {

using bot_core::image_t;

bool is_whole(const image_t& image, int pixel_bytes) {
  constexpr int kLargestSide = 1 << 16;
  if (image.width < 1 || image.height < 1 || image.width > kLargestSide ||
      image.height > kLargestSide || image.row_stride < image.width * pixel_bytes) {
    return false;
  }
  const int64_t needed =
      int64_t{image.row_stride} * (image.height - 1) + int64_t{image.width} * pixel_bytes;
  return static_cast<int64_t>(image.data.size()) >= needed;
}

}  // namespace

int bytes_per_pixel(const image_t& image) {
  if (image.pixelformat == image_t::PIXEL_FORMAT_GRAY) return 1;
  const bool colour = image.pixelformat == image_t::PIXEL_FORMAT_RGB ||
                      image.pixelformat == image_t::PIXEL_FORMAT_BGR;
  return colour ? 3 : 0;
}

std::optional<std::vector<uint8_t>> plain_pixels(const image_t& image) {
  const int pixel_bytes = bytes_per_pixel(image);
  if (pixel_bytes == 0 || !is_whole(image, pixel_bytes)) return std::nullopt;
  const auto row_bytes =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(pixel_bytes);
  std::vector<uint8_t> pixels;
  pixels.reserve(row_bytes * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    const auto row = image.data.begin() + static_cast<std::ptrdiff_t>(y) * image.row_stride;
    pixels.insert(pixels.end(), row, row + static_cast<std::ptrdiff_t>(row_bytes));
  }
  if (image.pixelformat == image_t::PIXEL_FORMAT_BGR) {
    for (std::size_t i = 0; i + 2 < pixels.size(); i += 3) std::swap(pixels[i], pixels[i + 2]);
  }
  return pixels;
}

}  // namespace marco
