#include "lcm_tools/spy/system.hpp"

#include <chrono>
#include <opencv2/imgcodecs.hpp>

namespace marco::spy {

std::optional<GrayImage> decode_jpeg(std::span<const uint8_t> bytes) {
  if (bytes.empty()) return {};
  try {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U,
                          const_cast<uint8_t*>(bytes.data()));
    const cv::Mat image = cv::imdecode(encoded, cv::IMREAD_REDUCED_GRAYSCALE_2);
    if (image.empty()) return {};
    return GrayImage{image.cols, image.rows, {image.begin<uint8_t>(), image.end<uint8_t>()}};
  } catch (const cv::Exception&) {
    return {};
  }
}

int64_t wall_clock_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace marco::spy
