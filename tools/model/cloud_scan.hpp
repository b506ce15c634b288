#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mapping3d/clouds/point_grid.hpp"

namespace marco {

/// A scan of another scanner, and what is known of its place.
struct CloudScan {
  std::filesystem::path path;
  std::size_t points = 0;  ///< that returned
  mapping3d::GriddedCloud grid;
  std::vector<std::array<uint8_t, 3>> colors_rgb;  ///< of the cloud's points, or empty
  std::vector<float> intensities;                  ///< likewise
  /// Without has_pose: the identity, until find_start_poses or registration gives one.
  Pose3 world_from_scanner = Pose3::Identity();
  bool has_pose = false;

  std::string name() const { return path.filename().string(); }
};

/// The point files among these files and below these folders, in the order of their names.
/// @throws std::invalid_argument naming the input in which there is none.
std::vector<std::filesystem::path> list_point_files(const std::vector<std::string>& inputs);

/// @throws std::invalid_argument as read_points, and for points that were not seen from the origin
/// of their frame.
CloudScan read_cloud_scan(const std::filesystem::path& path);

}  // namespace marco
