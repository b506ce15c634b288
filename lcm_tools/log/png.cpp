#include "lcm_tools/log/png.hpp"

#include <png.h>

#include <stdexcept>

#include "lcm_tools/base/check.hpp"

namespace marco::logs {

std::string to_png(std::span<const uint8_t> pixels, int width_px, int pixel_bytes) {
  require(width_px > 0 && (pixel_bytes == 1 || pixel_bytes == 3), "a PNG of 1 or 3 bytes a pixel");
  const auto row_bytes = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(pixel_bytes);
  require(!pixels.empty() && pixels.size() % row_bytes == 0, "a PNG of whole rows");
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_px);
  image.height = static_cast<png_uint_32>(pixels.size() / row_bytes);
  image.format = pixel_bytes == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string png(bytes, '\0');
  if (png_image_write_to_memory(&image, png.data(), &bytes, 0, pixels.data(), 0, nullptr) == 0) {
    throw std::runtime_error(std::string("cannot write a PNG: ") + image.message);
  }
  png.resize(bytes);
  return png;
}

}  // namespace marco::logs
