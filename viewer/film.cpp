#include "viewer/film.hpp"

#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/output_file.hpp"

namespace marco::viewer {

struct FilmWriter::Implementation {
  // FFmpeg knows the kind of film by the ending.
  explicit Implementation(const std::string& path)
      : file(path, files::Appears::when_whole, ".part.mp4"), name(path) {}
  files::OutputFile file;
  std::string name;
  cv::VideoWriter writer;
};

FilmWriter::FilmWriter(const std::string& path, int width_px, int height_px, double frames_per_s)
    : width_px_(width_px), height_px_(height_px) {
  require(width_px > 0 && height_px > 0 && width_px % 2 == 0 && height_px % 2 == 0,
          "a film needs an even width and height above 0 px, not " + std::to_string(width_px) +
              "x" + std::to_string(height_px));
  require(frames_per_s > 0.0, "a film needs more than 0 frames per second");
  implementation_ = std::make_unique<Implementation>(path);
  implementation_->writer.open(implementation_->file.unfinished_path(), cv::CAP_FFMPEG,
                               cv::VideoWriter::fourcc('m', 'p', '4', 'v'), frames_per_s,
                               cv::Size(width_px, height_px));
  if (!implementation_->writer.isOpened())
    throw std::runtime_error(
        "cannot write film " + path +
        ": does the folder exist, and is libopencv-videoio built with FFmpeg?");
}

FilmWriter::~FilmWriter() = default;

void FilmWriter::add(const Picture& picture) {
  require(picture.width_px == width_px_ && picture.height_px == height_px_,
          "a picture whose size differs from the film's");
  const cv::Mat rgb(height_px_, width_px_, CV_8UC3, const_cast<Rgb*>(picture.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  implementation_->writer.write(bgr);
  ++frames_;
}

void FilmWriter::finish() {
  implementation_->writer.release();
  // OpenCV does not report a full disk: the film is read back.
  cv::VideoCapture film(implementation_->file.unfinished_path(), cv::CAP_FFMPEG);
  const int whole = static_cast<int>(film.get(cv::CAP_PROP_FRAME_COUNT));
  if (!film.isOpened() || whole < frames_)
    throw std::runtime_error("film " + implementation_->name +
                             " is incomplete: " + std::to_string(whole) + " of " +
                             std::to_string(frames_) + " pictures; is the disk full?");
  implementation_->file.finish();
}

std::vector<Camera> drive_cameras(const Trajectory& path, double step_m, double eye_height_m) {
  require(step_m > 0.0, "the step between two pictures of a drive must be above 0 m");
  constexpr double kHeadingBlend = 0.25;
  std::vector<Camera> cameras;
  Pose2 last;
  double heading_rad = 0.0;
  for (const StampedPose2& stamped : path) {
    const Pose2& pose = stamped.world_from_robot;
    if (!is_finite(pose)) continue;
    constexpr double kTurnRad = 0.05;
    if (!cameras.empty() && (pose.translation_m() - last.translation_m()).norm() < step_m &&
        std::abs(normalize_angle(pose.theta_rad - last.theta_rad)) < kTurnRad)
      continue;
    heading_rad = cameras.empty()
                      ? pose.theta_rad
                      : heading_rad + kHeadingBlend * normalize_angle(pose.theta_rad - heading_rad);
    cameras.push_back(
        camera_at(make_pose3({pose.x_m, pose.y_m, eye_height_m}, 0.0, 0.0, heading_rad)));
    last = pose;
  }
  require(!cameras.empty(), "a drive needs a path with a finite pose");
  return cameras;
}

Picture contact_sheet(const std::vector<Picture>& pictures, int columns) {
  require(!pictures.empty() && columns >= 1, "a contact sheet needs a picture and a column");
  const int width = pictures[0].width_px, height = pictures[0].height_px;
  const int count = static_cast<int>(pictures.size());
  const int across = std::min(columns, count), rows = (count + across - 1) / across;
  const int gap = std::max(2, width / 100);
  Picture sheet(across * (width + gap) + gap, rows * (height + gap) + gap, palette::kPaper);
  for (int i = 0; i < count; ++i) {
    const Picture& picture = pictures[static_cast<std::size_t>(i)];
    require(picture.width_px == width && picture.height_px == height,
            "pictures of one contact sheet must have one size");
    const int left = gap + (i % across) * (width + gap), top = gap + (i / across) * (height + gap);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) sheet.at(left + x, top + y) = picture.at(x, y);
  }
  return sheet;
}

}  // namespace marco::viewer
