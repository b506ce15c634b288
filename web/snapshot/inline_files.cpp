#include "web/snapshot/inline_files.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <span>

#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/schema/json.hpp"

namespace marco::web {
namespace {

using nlohmann::json;

constexpr int kLongestSidePx = 1024, kJpegQuality = 80;

std::string data_url(const char* type, std::span<const uint8_t> bytes) {
  return std::string("data:") + type + ";base64," + lcm_schema::to_base64(bytes);
}

// Empty when it is no picture.
std::vector<uint8_t> small_jpeg(const std::filesystem::path& file) {
  cv::Mat picture = cv::imread(file.string(), cv::IMREAD_COLOR);
  if (picture.empty()) return {};
  const double scale = double{kLongestSidePx} / std::max(picture.cols, picture.rows);
  if (scale < 1.0) cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  return jpeg;
}

}  // namespace

std::string inline_files(const std::string& snapshot, const std::filesystem::path& folder) {
  json content = json::parse(snapshot);
  if (content["model"].is_string()) {
    const std::string name = content["model"].get<std::string>().substr(6);  // behind "files/"
    const std::string model = files::read_whole_file(files::inside_folder(folder, name));
    content["model"] = data_url("model/gltf-binary",
                                {reinterpret_cast<const uint8_t*>(model.data()), model.size()});
  }
  json photographs = json::array();
  for (json& photograph : content["photographs"]) {
    const auto jpeg =
        small_jpeg(files::inside_folder(folder, photograph["file"].get<std::string>()));
    if (jpeg.empty()) continue;
    photograph["file"] = data_url("image/jpeg", jpeg);
    photographs.push_back(std::move(photograph));
  }
  content["photographs"] = std::move(photographs);
  return content.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace marco::web
