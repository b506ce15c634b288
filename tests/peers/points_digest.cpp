// What our readers find in files of points, for comparison with other people's: points_digest FILE
// [--to FORMAT OUT] prints FILE's format, count, extents, means and pose, and writes it in FORMAT.
#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

#include "common/files/points/point_files.hpp"

namespace {

using marco::files::PointFormat;
constexpr std::array<std::string_view, 6> kNames = {"pcd", "ply", "xyz", "pts", "ptx", "uos"};

void print_digest(PointFormat format, const marco::PointCloud& cloud) {
  Eigen::AlignedBox3d extents;
  std::size_t returns = 0;
  for (const Eigen::Vector3f& point : cloud.points_m) {
    if (!point.allFinite()) continue;
    extents.extend(Eigen::Vector3d(point.cast<double>() + cloud.origin_m));
    ++returns;
  }
  double intensity = 0.0;
  for (const float value : cloud.intensities) intensity += static_cast<double>(value);
  Eigen::Vector3d color = Eigen::Vector3d::Zero();
  for (const auto& [red, green, blue] : cloud.colors_rgb)
    color += Eigen::Vector3d(red, green, blue);
  const Eigen::Vector3d& low = extents.min();
  const Eigen::Vector3d& high = extents.max();
  std::printf("format %s\npoints %zu\nreturns %zu\nrows %zu\n",
              kNames[static_cast<std::size_t>(format)].data(), cloud.points_m.size(), returns,
              cloud.rows);
  std::printf("extents %.5f %.5f %.5f %.5f %.5f %.5f\n", low.x(), low.y(), low.z(), high.x(),
              high.y(), high.z());
  const auto mean_of = [](double sum, std::size_t count) {
    return sum / static_cast<double>(std::max<std::size_t>(1, count));
  };
  std::printf("intensities %zu %.6f\n", cloud.intensities.size(),
              mean_of(intensity, cloud.intensities.size()));
  const std::size_t colored = cloud.colors_rgb.size();
  std::printf("colors %zu %.5f %.5f %.5f\n", colored, mean_of(color.x(), colored),
              mean_of(color.y(), colored), mean_of(color.z(), colored));
  if (!cloud.world_from_scanner) return;
  const Eigen::Vector3d& at = cloud.world_from_scanner->translation();
  const Eigen::Quaterniond turned(cloud.world_from_scanner->linear());
  std::printf("pose %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", at.x(), at.y(), at.z(), turned.w(),
              turned.x(), turned.y(), turned.z());
}

int digest(int argc, char** argv) {
  const bool writes = argc == 5 && std::string_view(argv[2]) == "--to";
  if (argc != 2 && !writes) {
    std::fputs("usage: points_digest FILE [--to FORMAT OUT]\n", stderr);
    return 2;
  }
  const auto format = marco::files::point_format_of(argv[1]);
  const marco::PointCloud cloud = marco::files::read_points(argv[1]);
  if (format) print_digest(*format, cloud);
  if (!writes) return 0;
  const auto wanted = std::find(kNames.begin(), kNames.end(), argv[3]);
  if (wanted == kNames.end()) return 2;
  marco::files::write_points(argv[4], static_cast<PointFormat>(wanted - kNames.begin()), cloud);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return digest(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
