#include "tools/log/export_images.hpp"

#include "bot_core/image_t.hpp"
#include "common/check.hpp"
#include "common/files/whole_file.hpp"
#include "tools/log/export_csv.hpp"
#include "tools/log/png.hpp"

namespace marco::logs {
namespace {

using bot_core::image_t;

int bytes_per_pixel(const image_t& image) {
  if (image.pixelformat == image_t::PIXEL_FORMAT_GRAY) return 1;
  const bool colour = image.pixelformat == image_t::PIXEL_FORMAT_RGB ||
                      image.pixelformat == image_t::PIXEL_FORMAT_BGR;
  return colour ? 3 : 0;
}

bool is_whole(const image_t& image, int pixel_bytes) {
  constexpr int kLargestSide = 1 << 16;
  if (image.width < 1 || image.height < 1 || image.width > kLargestSide ||
      image.height > kLargestSide || image.row_stride < image.width * pixel_bytes) {
    return false;
  }
  const int64_t needed =
      static_cast<int64_t>(image.row_stride) * (image.height - 1) + image.width * pixel_bytes;
  return static_cast<int64_t>(image.data.size()) >= needed;
}

// The pixels row by row without padding, colours in the order red, green, blue.
std::vector<uint8_t> pixels_of(const image_t& image, int pixel_bytes) {
  const auto row_bytes = static_cast<std::size_t>(image.width * pixel_bytes);
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

}  // namespace

ImagesResult export_images(WalkInput& input,
                           const Types& types,
                           const std::filesystem::path& folder,
                           Existing existing,
                           const OnProgress& on_progress) {
  require(existing == Existing::replace || !std::filesystem::exists(folder) ||
              std::filesystem::is_empty(folder),
          folder.string() + ": is not empty; --force writes into it");
  std::filesystem::create_directories(folder);
  ImagesResult result;
  result.walk = walk_log(
      input, types,
      [&](const DecodedEvent& event) {
        const auto fingerprint = lcm_schema::fingerprint_of(event.bytes);
        if (!fingerprint || *fingerprint != static_cast<uint64_t>(image_t::getHash())) return;
        image_t image{};
        if (event.structure < 0 ||
            image.decode(event.bytes.data(), 0, static_cast<int>(event.bytes.size())) < 0) {
          ++result.broken;
          return;
        }
        const std::filesystem::path stem =
            folder / (file_name_of(event.head.channel) + "_" + std::to_string(image.utime));
        if (image.pixelformat == image_t::PIXEL_FORMAT_MJPEG) {
          files::write_whole_file(
              stem.string() + ".jpg",
              {reinterpret_cast<const char*>(image.data.data()), image.data.size()});
          ++result.written;
          return;
        }
        const int pixel_bytes = bytes_per_pixel(image);
        if (pixel_bytes == 0) {
          ++result.unknown_format;
        } else if (!is_whole(image, pixel_bytes)) {
          ++result.broken;
        } else {
          files::write_whole_file(stem.string() + ".png",
                                  to_png(pixels_of(image, pixel_bytes), image.width, pixel_bytes));
          ++result.written;
        }
      },
      on_progress);
  return result;
}

}  // namespace marco::logs
