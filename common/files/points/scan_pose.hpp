#pragma once

#include <filesystem>
#include <string>

#include "common/pose3.hpp"

namespace marco::files {

/// A pose from its matrix. @throws std::invalid_argument naming the file when it turns not, but
/// stretches or mirrors.
Pose3 rigid_pose(const Eigen::Matrix4d& matrix, const std::string& name);

/// From a quaternion [w x y z]. @throws as above when its length is not 1.
Pose3 quaternion_pose(const Eigen::Vector3d& position_m,
                      const Eigen::Vector4d& wxyz,
                      const std::string& name);

/// NAME.pose next to a point file.
std::filesystem::path pose_path_of(const std::filesystem::path& points);

/// Writes six numbers, as 3DTK has them: see read_scan_pose(). @throws std::runtime_error naming
/// the path when it cannot be written.
void write_scan_pose(const std::filesystem::path& path, const Pose3& world_from_scanner);

}  // namespace marco::files
