#include "lcm_tools/log/export_images.hpp"

#include "bot_core/image_t.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/output_folder.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/log/export_csv.hpp"
#include "lcm_tools/log/image_pixels.hpp"
#include "lcm_tools/log/png.hpp"

namespace marco::logs {

using bot_core::image_t;

ImagesResult export_images(WalkInput& input,
                           const Types& types,
                           const std::filesystem::path& folder,
                           Existing existing,
                           const OnProgress& on_progress) {
  OutputFolder results(folder, existing, "export-images", input.path);
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
            results.path() / (file_name_of(event.head.channel) + "_" + std::to_string(image.utime));
        if (image.pixelformat == image_t::PIXEL_FORMAT_MJPEG) {
          files::write_whole_file(
              stem.string() + ".jpg",
              {reinterpret_cast<const char*>(image.data.data()), image.data.size()},
              files::Appears::when_renamed);
          ++result.written;
          return;
        }
        const int pixel_bytes = bytes_per_pixel(image);
        if (pixel_bytes == 0) {
          ++result.unknown_format;
        } else if (const auto pixels = plain_pixels(image)) {
          files::write_whole_file(stem.string() + ".png", to_png(*pixels, image.width, pixel_bytes),
                                  files::Appears::when_renamed);
          ++result.written;
        } else {
          ++result.broken;
        }
      },
      on_progress);
  results.commit();
  return result;
}

}  // namespace marco::logs
