#include "web/snapshot/export_html.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <span>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/schema/json.hpp"
#include "web/page/page_files.hpp"
#include "web/snapshot/bundle.hpp"
#include "web/snapshot/snapshot.hpp"

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

/// A snapshot whose model and photographs are data: URLs instead of names of files: pictures as
/// JPEG of at most 1024 pixels a side. A picture that cannot be read is left out.
/// @param snapshot  what snapshot_json(folder) gave
/// @throws std::invalid_argument when the model cannot be read.
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

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at)) {
    text.replace(at, from.size(), to);
    at += to.size();
  }
}

// What stands in the page for a file of its own.
void replace_line(std::string& page, std::string_view line, const std::string& content) {
  const std::size_t at = page.find(line);
  require(at != std::string::npos, "index.html lacks " + std::string(line));
  page.replace(at, line.size(), content);
}

// The end of a script may stand in its strings only as <\/script>; the same text for JavaScript.
std::string script(const std::string& attributes, std::string content) {
  replace_all(content, "</", "<\\/");
  replace_all(content, "<!--", "<\\!--");
  return "<script" + attributes + ">" + content + "</script>";
}

}  // namespace

std::string export_html(const std::filesystem::path& folder, const std::filesystem::path& three) {
  std::string snapshot = inline_files(snapshot_json(folder), folder);
  replace_all(snapshot, "<", "\\u003c");
  std::string page(page_file("index.html").value());
  std::string scripts = script(" type=\"application/json\" id=\"snapshot\"", snapshot);
  const bool has_model = snapshot.find("\"model\":null") == std::string::npos;
  if (has_model && std::filesystem::exists(three)) {
    scripts += script(" type=\"text/plain\" id=\"three\"", files::read_whole_file(three));
  }
  scripts += script("", bundle_modules("app.js", page_file));
  replace_line(page, R"(<link rel="stylesheet" href="page/page.css">)",
               "<style>\n" + std::string(page_file("page.css").value()) + "</style>");
  replace_line(page, R"(<script type="module" src="page/app.js"></script>)", scripts);
  return page;
}

}  // namespace marco::web
