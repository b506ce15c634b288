#include <algorithm>

#include "common/files/ply_elements.hpp"
#include "common/files/point_columns.hpp"
#include "common/files/points/point_collector.hpp"
#include "common/files/points/point_formats.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

void read_vertex_points(PlyElements& ply,
                        const PlyElement& element,
                        const std::string& name,
                        PointCollector& points) {
  const std::vector<std::string> names = element.number_names();
  const PointColumns columns = find_point_columns(names);
  require(columns.xyz.has_value(), name + ": its vertices have no x, y, z");
  PlyElements::Wanted wanted{{columns.xyz->begin(), columns.xyz->end()}, std::nullopt};
  if (columns.rgb) {
    wanted.numbers.insert(wanted.numbers.end(), columns.rgb->begin(), columns.rgb->end());
  }
  if (columns.intensity) wanted.numbers.push_back(*columns.intensity);
  std::array<Scalar, 3> color_types{};
  for (std::size_t i = 0; columns.rgb && i < 3; ++i) {
    color_types[i] = element.properties[(*columns.rgb)[i]].type;
  }
  points.reserve(element.count, {columns.intensity.has_value(), columns.rgb.has_value()});
  PointCloud& cloud = points.cloud;
  ply.read_next(wanted, [&](std::span<const double> numbers, std::span<const double>) {
    points.add({numbers[0], numbers[1], numbers[2]});
    if (columns.intensity) cloud.intensities.push_back(static_cast<float>(numbers.back()));
    if (!columns.rgb) return;
    const auto byte = [&](std::size_t i) { return color_byte(numbers[3 + i], color_types[i]); };
    cloud.colors_rgb.push_back({byte(0), byte(1), byte(2)});
  });
}

std::string ply_header_of(const PointCloud& cloud, std::size_t count, bool is_far) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\ncomment metres, x forward, y left, z up\n";
  text += "element vertex " + std::to_string(count) + "\n";
  for (const char* axis : {"x", "y", "z"}) {
    text += std::string("property ") + (is_far ? "double " : "float ") + axis + "\n";
  }
  if (!cloud.intensities.empty()) text += "property float intensity\n";
  if (!cloud.colors_rgb.empty()) {
    text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  }
  return text + "end_header\n";
}

}  // namespace

PointCloud read_ply_points(const std::string& content, const std::string& name) {
  return collect_points([&](PointCollector& points) {
    PlyElements ply(content, name);
    for (const PlyElement& element : ply.elements()) {
      if (element.name == "vertex") return read_vertex_points(ply, element, name, points);
      ply.skip_next();
    }
    throw std::invalid_argument(name + ": it has no vertices");
  });
}

void write_ply_points(OutputFile& file, const PointCloud& cloud) {
  const bool is_far = !cloud.origin_m.isZero(0.0);
  const auto count = std::count_if(cloud.points_m.begin(), cloud.points_m.end(),
                                   [](const Eigen::Vector3f& p) { return p.allFinite(); });
  file.write(ply_header_of(cloud, static_cast<std::size_t>(count), is_far));
  std::string bytes;
  const auto append = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
    const Eigen::Vector3f& point = cloud.points_m[i];
    if (!point.allFinite()) continue;
    for (int axis = 0; axis < 3; ++axis) {
      if (is_far) {
        append(static_cast<double>(point[axis]) + cloud.origin_m[axis]);
      } else {
        append(point[axis]);
      }
    }
    if (!cloud.intensities.empty()) append(cloud.intensities[i]);
    if (!cloud.colors_rgb.empty()) append(cloud.colors_rgb[i]);
    file.write(bytes);
    bytes.clear();
  }
}

}  // namespace marco::files
