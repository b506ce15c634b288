#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/pose3.hpp"

namespace marco {

/// The points of one 3D scan. Float: a millimetre at 8 km from origin_m.
struct PointCloud {
  /// In the scanner's frame, from origin_m; not finite: a beam without a return.
  std::vector<Eigen::Vector3f> points_m;
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< of coordinates as large as a survey's
  std::vector<float> intensities;                      ///< empty or one a point, in the file's unit
  std::vector<std::array<uint8_t, 3>> colors_rgb;      ///< empty or one a point
  /// Of an organized scan, whose points lie row by row; 0: in no order.
  std::size_t rows = 0;
  std::optional<Pose3> world_from_scanner;  ///< where the file says it
};

}  // namespace marco
