#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace marco::drivers::camera {

/// A picture as it goes out.
struct Picture {
  int width_px = 0;
  int height_px = 0;
  std::vector<uint8_t> jpeg;
};

struct SourceOptions {
  int width_px = 640;  ///< asked of a camera; others send what they have
  int height_px = 480;
  double rate_hz = 5.0;  ///< of pictures and films; of a camera the most that is passed on
  int jpeg_quality = 85;
};

/// @param rgb  rows from the top, three bytes a pixel.
Picture compress_rgb(std::span<const uint8_t> rgb, int width_px, int height_px, int jpeg_quality);

/// Where pictures come from.
class PictureSource {
 public:
  virtual ~PictureSource() = default;
  /// Waits for the next. @returns nothing when the source has ended or is gone.
  virtual std::optional<Picture> next() = 0;
  /// Whether pictures come by themselves, or as fast as they are asked for.
  virtual bool keeps_its_own_time() const = 0;
};

/// "/dev/video2" of "2"; every other address is a path already.
std::string path_of(const std::string& address);

/// @param address  a device (/dev/video0, or its number), a folder of pictures (in the order of
/// their names, again and again), or a film.
/// @returns nothing when there is no such thing now.
std::unique_ptr<PictureSource> open_source(const std::string& address,
                                           const SourceOptions& options);

}  // namespace marco::drivers::camera
