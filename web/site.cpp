#include "web/site.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

#include "lcm_tools/files/inside_folder.hpp"

namespace marco::web {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<std::string_view, std::string_view>, 11> kTypes = {
    {{".html", "text/html; charset=utf-8"},
     {".css", "text/css; charset=utf-8"},
     {".js", "text/javascript; charset=utf-8"},
     {".json", "application/json"},
     {".svg", "image/svg+xml"},
     {".png", "image/png"},
     {".jpg", "image/jpeg"},
     {".jpeg", "image/jpeg"},
     {".ico", "image/x-icon"},
     {".glb", "model/gltf-binary"},
     {".webmanifest", "application/manifest+json"}}};

std::string_view type_of(const fs::path& path) {
  const std::string extension = path.extension().string();
  for (const auto& [known, type] : kTypes) {
    if (known == extension) return type;
  }
  return "application/octet-stream";
}

/// "%2e" and its like as their bytes; a '%' without two digits stays.
std::string decoded(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned byte = 0;
    const char* digits = text.data() + i + 1;
    if (text[i] == '%' && i + 2 < text.size() &&
        std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
      plain += static_cast<char>(byte);
      i += 2;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

Site::Answer file(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  return {200, std::string(type_of(path)), "", path};
}

void add_name(const nlohmann::json& value, std::set<std::string>& names) {
  constexpr std::string_view kFiles = "files/";
  if (!value.is_string()) return;
  const auto text = value.get<std::string>();
  if (text.starts_with("data:")) return;
  names.insert(text.starts_with(kFiles) ? text.substr(kFiles.size()) : text);
}

}  // namespace

std::string query_value(std::string_view target, std::string_view key) {
  const std::size_t mark = target.find('?');
  if (mark == std::string_view::npos) return "";
  std::string_view query = target.substr(mark + 1);
  while (!query.empty()) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view pair = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    const std::size_t equals = pair.find('=');
    if (equals != std::string_view::npos && pair.substr(0, equals) == key) {
      return decoded(pair.substr(equals + 1));
    }
  }
  return "";
}

Site::Site(Page page, fs::path three) : page_(std::move(page)), three_(std::move(three)) {}

void Site::show_folder(fs::path folder, std::string json) {
  folder_ = std::move(folder);
  const auto snapshot = nlohmann::json::parse(json, nullptr, false);
  named_.clear();
  if (snapshot.is_object()) {
    if (snapshot.contains("model")) add_name(snapshot["model"], named_);
    const auto photographs = snapshot.find("photographs");
    if (photographs != snapshot.end() && photographs->is_array()) {
      for (const auto& one : *photographs) {
        if (one.is_object() && one.contains("file")) add_name(one["file"], named_);
      }
    }
  }
  snapshot_ = std::move(json);
}

Site::Answer Site::get(std::string_view target) const {
  constexpr std::string_view kPage = "/page/", kFiles = "/files/";
  const std::string path = decoded(target.substr(0, target.find_first_of("?#")));
  const auto of_page = [this](std::string_view name) -> Answer {
    const auto text = page_(name);
    return text ? Answer{200, std::string(type_of(name)), std::string(*text), {}} : Answer{};
  };
  if (path == "/" || path == "/index.html") return of_page("index.html");
  if (path == "/page/three.js") return file(three_);
  if (path == "/snapshot.json" && snapshot_) return {200, "application/json", *snapshot_, {}};
  if (path.starts_with(kPage)) return of_page(path.substr(kPage.size()));
  if (!path.starts_with(kFiles) || !named_.contains(path.substr(kFiles.size()))) return {};
  // The snapshot's names come from the folder's own files, which may have come from anybody.
  try {
    return file(files::inside_folder(folder_, path.substr(kFiles.size())));
  } catch (const std::invalid_argument&) {
    return {};
  }
}

}  // namespace marco::web
