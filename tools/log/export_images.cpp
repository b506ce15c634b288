#include "tools/log/export_images.hpp"

#include "bot_core/image_t.hpp"
#include "common/check.hpp"
#include "common/files/whole_file.hpp"
#include "tools/log/export_csv.hpp"
#include "viewer/image_io.hpp"

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

viewer::Picture picture_of(const image_t& image, int pixel_bytes) {
  viewer::Picture picture(image.width, image.height, {});
  const bool bgr = image.pixelformat == image_t::PIXEL_FORMAT_BGR;
  for (int y = 0; y < image.height; ++y) {
    const uint8_t* row = image.data.data() + static_cast<std::ptrdiff_t>(y) * image.row_stride;
    for (int x = 0; x < image.width; ++x) {
      const uint8_t* pixel = row + static_cast<std::ptrdiff_t>(x) * pixel_bytes;
      if (pixel_bytes == 1) {
        picture.at(x, y) = {pixel[0], pixel[0], pixel[0]};
      } else {
        picture.at(x, y) = {pixel[bgr ? 2 : 0], pixel[1], pixel[bgr ? 0 : 2]};
      }
    }
  }
  return picture;
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
          viewer::write_png(picture_of(image, pixel_bytes), stem.string() + ".png");
          ++result.written;
        }
      },
      on_progress);
  return result;
}

}  // namespace marco::logs
