#include "tools/model/cloud_scan.hpp"

#include <algorithm>
#include <cmath>

#include "common/files/points/point_files.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"

namespace marco {
namespace {

namespace fs = std::filesystem;

// Rooms that were scanned one by one and put into one file have 0.3 and more. In a scan from one
// place it is the share of directions that graze an edge: below 0.05.
constexpr double kMostLayered = 0.15;

void add_files(const fs::path& input, std::vector<fs::path>& found) {
  if (!fs::is_directory(input)) {
    if (files::point_format_of(input)) found.push_back(input);
    return;
  }
  for (const auto& entry : fs::directory_iterator(input)) {
    const fs::path& path = entry.path();
    if (entry.is_regular_file() && path.extension() != ".pose" && files::point_format_of(path)) {
      found.push_back(path);
    }
  }
}

}  // namespace

std::vector<fs::path> list_point_files(const std::vector<std::string>& inputs) {
  std::vector<fs::path> all;
  for (const std::string& input : inputs) {
    files::require_readable(input);
    const std::size_t before = all.size();
    add_files(input, all);
    require(all.size() > before,
            input + ": contains no points (PCD, PLY, XYZ, PTS, PTX, or .3d of uos)");
    std::sort(all.begin() + static_cast<std::ptrdiff_t>(before), all.end());
  }
  return all;
}

CloudScan read_cloud_scan(const fs::path& path) {
  PointCloud cloud = files::read_points(path);
  CloudScan scan;
  scan.path = path;
  scan.grid = mapping3d::grid(cloud);
  require(scan.grid.scene.rows >= 2 && scan.grid.scene.columns >= 2,
          path.string() + ": too few points for a scan");
  char share[8];
  std::snprintf(share, sizeof share, "%.0f", 100.0 * scan.grid.layered);
  require(cloud.origin_m.isZero() && scan.grid.layered < kMostLayered,
          path.string() + ": these points were not seen from the origin of their frame (in " +
              share +
              " % of the directions one is behind another); put each scan into a separate file, in "
              "the scanner's frame, with the scanner's pose in NAME.pose next to it");
  for (const Eigen::Vector3f& point_m : cloud.points_m) scan.points += point_m.allFinite() ? 1 : 0;
  scan.colors_rgb = std::move(cloud.colors_rgb);
  scan.intensities = std::move(cloud.intensities);
  scan.has_pose = cloud.world_from_scanner.has_value();
  if (scan.has_pose) scan.world_from_scanner = *cloud.world_from_scanner;
  return scan;
}

}  // namespace marco
