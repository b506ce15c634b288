#include "viewer/image_io.hpp"

#include <climits>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/output_file.hpp"
#include "lcm_tools/files/readable.hpp"

namespace marco::viewer {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw std::runtime_error("cannot write picture " + path + ": " + why);
}

std::vector<uint8_t> encode_png(const Picture& picture, const std::string& path) {
  // imencode only reads, but cv::Mat knows no const pixels.
  const cv::Mat rgb(picture.height_px, picture.width_px, CV_8UC3,
                    const_cast<Rgb*>(picture.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<uint8_t> bytes;
  if (!cv::imencode(".png", bgr, bytes)) fail(path, "the picture cannot be encoded as PNG");
  return bytes;
}

Picture rgb_of(const cv::Mat& bgr) {
  Picture picture(bgr.cols, bgr.rows, {});
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, picture.pixels.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return picture;
}

}  // namespace

void write_png(const Picture& picture, const std::string& path) {
  require(picture.width_px > 0 && picture.height_px > 0, "an empty picture cannot be written");
  files::OutputFile file(path);
  file.write(encode_png(picture, path));
  file.finish();
}

Picture read_picture(const std::string& path) {
  // OpenCV would print a warning of its own.
  const std::string why = files::why_not_readable(path);
  const cv::Mat bgr = why.empty() ? cv::imread(path, cv::IMREAD_COLOR) : cv::Mat();
  if (bgr.empty()) {
    throw std::runtime_error(path + ": " +
                             (why.empty() ? "not a picture that OpenCV can read" : why));
  }
  return rgb_of(bgr);
}

Picture decode_picture(std::string_view bytes) {
  // imdecode only reads, but cv::Mat knows no const bytes.
  const cv::Mat encoded(1, static_cast<int>(std::min<std::size_t>(bytes.size(), INT_MAX)), CV_8UC1,
                        const_cast<char*>(bytes.data()));
  const cv::Mat bgr = bytes.empty() ? cv::Mat() : cv::imdecode(encoded, cv::IMREAD_COLOR);
  require(!bgr.empty(), "not a picture");
  return rgb_of(bgr);
}

}  // namespace marco::viewer
