#include "drivers/camera/source.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "lcm_tools/base/check.hpp"

namespace marco::drivers::camera {
namespace {

namespace fs = std::filesystem;

Picture compress(const cv::Mat& image, int quality) {
  Picture picture;
  picture.width_px = image.cols;
  picture.height_px = image.rows;
  cv::imencode(".jpg", image, picture.jpeg, {cv::IMWRITE_JPEG_QUALITY, quality});
  return picture;
}

bool is_picture(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".jpg" || ending == ".jpeg" || ending == ".png" || ending == ".ppm" ||
         ending == ".pgm";
}

class PictureFolder : public PictureSource {
 public:
  PictureFolder(std::vector<fs::path> files, int quality)
      : files_(std::move(files)), quality_(quality) {}

  std::optional<Picture> next() override {
    // One that cannot be read is passed by; a folder of nothing else is no source.
    for (std::size_t tried = 0; tried < files_.size(); ++tried) {
      const fs::path& path = files_[next_++ % files_.size()];
      const cv::Mat image = cv::imread(path.string(), cv::IMREAD_COLOR);
      if (!image.empty()) return compress(image, quality_);
    }
    return std::nullopt;
  }
  bool keeps_its_own_time() const override { return false; }

 private:
  std::vector<fs::path> files_;
  std::size_t next_ = 0;
  int quality_;
};

class Capture : public PictureSource {
 public:
  Capture(const cv::VideoCapture& capture, bool film, int quality)
      : capture_(capture), film_(film), quality_(quality) {}

  std::optional<Picture> next() override {
    cv::Mat image;
    if (!capture_.read(image) || image.empty()) return std::nullopt;
    return compress(image, quality_);
  }
  bool keeps_its_own_time() const override { return !film_; }

 private:
  cv::VideoCapture capture_;
  bool film_;
  int quality_;
};

std::unique_ptr<PictureSource> open_folder(const std::string& folder, int quality) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && is_picture(entry.path())) files.push_back(entry.path());
  }
  if (files.empty()) return nullptr;
  std::sort(files.begin(), files.end());
  return std::make_unique<PictureFolder>(std::move(files), quality);
}

}  // namespace

Picture compress_rgb(std::span<const uint8_t> rgb, int width_px, int height_px, int jpeg_quality) {
  cv::Mat image(height_px, width_px, CV_8UC3);
  require(rgb.size() == image.total() * 3, "a picture has three bytes a pixel");
  for (std::size_t i = 0; i < rgb.size(); ++i) image.data[i] = rgb[i - i % 3 + (2 - i % 3)];  // BGR
  return compress(image, jpeg_quality);
}

std::string path_of(const std::string& address) {
  const bool number = !address.empty() && std::all_of(address.begin(), address.end(),
                                                      [](char c) { return c >= '0' && c <= '9'; });
  return number ? "/dev/video" + address : address;
}

std::unique_ptr<PictureSource> open_source(const std::string& address,
                                           const SourceOptions& options) {
  const std::string path = path_of(address);
  std::error_code error;
  if (fs::is_directory(path, error)) return open_folder(path, options.jpeg_quality);
  if (!fs::exists(path, error)) return nullptr;
  const bool film = fs::is_regular_file(path, error);
  cv::VideoCapture capture;
  if (!capture.open(path, film ? cv::CAP_ANY : cv::CAP_V4L2)) return nullptr;
  if (!film) {
    capture.set(cv::CAP_PROP_FRAME_WIDTH, options.width_px);
    capture.set(cv::CAP_PROP_FRAME_HEIGHT, options.height_px);
  }
  return std::make_unique<Capture>(std::move(capture), film, options.jpeg_quality);
}

}  // namespace marco::drivers::camera
