#include "lcm_tools/log/png.hpp"

#include <png.h>

#include <csetjmp>
#include <new>
#include <stdexcept>

#include "lcm_tools/base/check.hpp"

namespace marco::logs {
namespace {

// libpng reports errors through functions that must not return, and warnings on stderr.
void jump_out(png_structp png, png_const_charp /*why*/) { png_longjmp(png, 1); }
void ignore(png_structp /*png*/, png_const_charp /*warning*/) {}

void append(png_structp png, png_bytep bytes, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))
      ->append(reinterpret_cast<const char*>(bytes), count);
}

// No local object here may have a destructor: longjmp would skip it.
bool write(png_structp png,
           png_infop info,
           std::span<const uint8_t> pixels,
           std::size_t row_bytes) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT(cert-err52-cpp): libpng's way
  png_write_info(png, info);
  for (std::size_t at = 0; at < pixels.size(); at += row_bytes) {
    png_write_row(png, pixels.data() + at);
  }
  png_write_end(png, info);
  return true;
}

struct Writer {
  Writer() = default;
  ~Writer() { png_destroy_write_struct(&png, &info); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, jump_out, ignore);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
};

}  // namespace

std::string to_png(std::span<const uint8_t> pixels, int width_px, int pixel_bytes, PngSize size) {
  constexpr int kMostPixels = 1000000;  // a side, libpng's limit
  require(width_px > 0 && width_px <= kMostPixels && (pixel_bytes == 1 || pixel_bytes == 3),
          "a PNG of 1 or 3 bytes a pixel");
  const auto row_bytes = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(pixel_bytes);
  const std::size_t rows = pixels.size() / row_bytes;
  require(rows > 0 && rows <= kMostPixels && pixels.size() % row_bytes == 0, "a PNG of whole rows");
  std::string bytes;
  bytes.reserve(pixels.size() + pixels.size() / 256 + rows + 4096);  // append must not throw
  const Writer writer;
  if (writer.info == nullptr) throw std::bad_alloc();
  png_set_write_fn(writer.png, &bytes, append, nullptr);
  png_set_compression_level(writer.png, size == PngSize::small ? 1 : 0);
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(width_px),
               static_cast<png_uint_32>(rows), 8,
               pixel_bytes == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(writer.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
  if (!write(writer.png, writer.info, pixels, row_bytes)) {
    throw std::runtime_error("libpng cannot write a picture");
  }
  return bytes;
}

}  // namespace marco::logs
