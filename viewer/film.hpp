#pragma once

#include <memory>
#include <string>
#include <vector>

#include "viewer/camera.hpp"
#include "viewer/picture.hpp"

namespace marco::viewer {

/// Writes pictures as an MP4 (MPEG-4 part 2, which every FFmpeg of OpenCV has). The file appears
/// under its name when it is complete (files::OutputFile). Not thread-safe.
class FilmWriter {
 public:
  /// @throws std::runtime_error naming the path when no film can be written there;
  /// std::invalid_argument unless the sides are even, above 0, and the rate is above 0.
  FilmWriter(const std::string& path, int width_px, int height_px, double frames_per_s);
  ~FilmWriter();
  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;

  /// @throws std::invalid_argument when the picture has another size than the film.
  void add(const Picture& picture);

  /// Ends the film. @throws std::runtime_error naming the path when it is not whole on the disk.
  void finish();

  int frame_count() const { return frames_; }

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
  int width_px_;
  int height_px_;
  int frames_ = 0;
};

/// Cameras along a path: at an even distance, with smoothed headings so that the film does not
/// shake.
/// @param eye_height_m above z = 0. @returns at least one camera.
/// @throws std::invalid_argument when the path has no finite pose or step_m is not above 0.
std::vector<Camera> drive_cameras(const Trajectory& path, double step_m, double eye_height_m);

/// Pictures of one size side by side, row by row, with a white gap.
/// @throws std::invalid_argument when there is none, sizes differ, or columns < 1.
Picture contact_sheet(const std::vector<Picture>& pictures, int columns);

}  // namespace marco::viewer
