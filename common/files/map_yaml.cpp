#include "common/files/map_yaml.hpp"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/files/readable.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {
namespace {

constexpr int kUnknownGrey = 205;
constexpr int kFreeGrey = 254;
constexpr int64_t kMostYamlBytes = 1 << 20;

uint8_t grey_of(uint8_t occupancy) {
  if (occupancy == GridMap::kUnknown) return kUnknownGrey;
  return static_cast<uint8_t>(kFreeGrey - (occupancy * kFreeGrey + 50) / 100);  // never 205
}

uint8_t occupancy_of(uint8_t grey) {
  if (grey == kUnknownGrey) return GridMap::kUnknown;
  const int darkness = kFreeGrey - (grey > kFreeGrey ? kFreeGrey : grey);
  return static_cast<uint8_t>((darkness * 100 + kFreeGrey / 2) / kFreeGrey);
}

struct Yaml {
  std::string image;
  double resolution_m = 0.0;
  Eigen::Vector2d origin_m = {0, 0};
};

Yaml parse_yaml(const std::string& text, const std::string& name) {
  Yaml yaml;
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::string key = line.substr(0, colon);
    std::string value = line.substr(colon + 1);
    if (key == "image") {
      const std::size_t first = value.find_first_not_of(" \"'"),
                        last = value.find_last_not_of(" \"'\r");
      yaml.image = first == std::string::npos ? "" : value.substr(first, last - first + 1);
    } else if (key == "resolution") {
      yaml.resolution_m = TextFields(value).number<double>().value_or(0.0);
    } else if (key == "origin") {
      for (char& c : value) c = c == '[' || c == ']' ? ' ' : c;
      TextFields fields(value);
      const auto x = fields.number<double>(), y = fields.number<double>();
      require(x && y, name + ": origin: expected [x, y, yaw]");
      yaml.origin_m = {*x, *y};
    }
  }
  require(!yaml.image.empty() && yaml.resolution_m > 0.0 && std::isfinite(yaml.resolution_m),
          name + ": expected the keys image and resolution (above 0)");
  return yaml;
}

// Cells alone: the header is looked at before anything is made for them.
GridMap read_pgm(const std::filesystem::path& path) {
  constexpr int64_t kMostCells = 1 << 30;  // 1.6 km by 1.6 km at 5 cm
  std::ifstream file = open_readable(path);
  const std::string head = first_bytes(path, 200);
  int width = 0, height = 0, largest = 0, header = 0;
  const int fields = std::sscanf(head.c_str(), "P5 %d %d %d%n", &width, &height, &largest, &header);
  const int64_t cells = int64_t{width} * height;
  require(fields == 3 && width > 0 && height > 0 && largest == 255,
          path.string() + ": expected a binary PGM (P5) with 255 greys");
  require(cells <= kMostCells, path.string() + ": has more than 2^30 cells");
  require(std::filesystem::file_size(path) > static_cast<uint64_t>(header + cells),
          path.string() + ": ends early");
  GridMap map;
  map.width_cells = width;
  map.height_cells = height;
  map.occupancy.resize(static_cast<std::size_t>(cells));
  file.seekg(header + 1);
  for (int y = height - 1; y >= 0; --y) {
    const auto row = map.occupancy.begin() + int64_t{y} * width;
    file.read(reinterpret_cast<char*>(&*row), width);
    std::transform(row, row + width, row, occupancy_of);
  }
  return map;
}

}  // namespace

void write_map(const std::filesystem::path& folder,
               const GridMap& map,
               const std::string& picture_name) {
  std::string picture =
      "P5\n" + std::to_string(map.width_cells) + " " + std::to_string(map.height_cells) + "\n255\n";
  for (int y = map.height_cells - 1; y >= 0; --y) {
    for (int x = 0; x < map.width_cells; ++x) {
      picture += static_cast<char>(grey_of(map.at(x, y)));
    }
  }
  write_whole_file(folder / picture_name, picture);
  write_whole_file(folder / "map.yaml",
                   "image: " + picture_name +
                       format("\nresolution: %.6f\norigin: [%.6f, %.6f, 0.0]\nnegate: 0\n"
                              "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
                              map.resolution_m, map.origin_m.x(), map.origin_m.y()));
}

std::string picture_of_map(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "map.yaml";
  if (!std::filesystem::exists(path)) return "";
  try {
    return parse_yaml(read_whole_file(path, kMostYamlBytes), path.string()).image;
  } catch (const std::invalid_argument&) {  // not ours, or broken: it names no picture
    return "";
  }
}

std::string next_picture_name(const std::string& picture_before) {
  int64_t number = 0;
  std::sscanf(picture_before.c_str(), "map_%" SCNd64 ".pgm", &number);
  return "map_" + std::to_string(std::max<int64_t>(0, number) + 1) + ".pgm";
}

GridMap read_map(const std::filesystem::path& yaml_path) {
  const Yaml yaml = parse_yaml(read_whole_file(yaml_path, kMostYamlBytes), yaml_path.string());
  std::filesystem::path picture_path;
  try {
    picture_path = inside_folder(yaml_path.parent_path(), yaml.image);
  } catch (const std::invalid_argument& outside) {
    throw std::invalid_argument(yaml_path.string() + ": the picture " + outside.what() +
                                ": put it next to the yaml file");
  }
  GridMap map = read_pgm(picture_path);
  map.origin_m = yaml.origin_m;
  map.resolution_m = yaml.resolution_m;
  return map;
}

}  // namespace marco::files
