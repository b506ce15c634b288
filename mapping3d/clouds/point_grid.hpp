#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "common/point_cloud.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// The scan of a scanner that stood still, in rows and columns of neighbouring directions.
struct GriddedCloud {
  static constexpr uint32_t kNoPoint = std::numeric_limits<uint32_t>::max();

  ScenePoints scene;               ///< scanner's frame
  std::vector<uint32_t> point_of;  ///< of each cell of the scene; kNoPoint: none, or filled in
  /// Part of the directions in which points lie at two depths: nearly none in a scan from one
  /// place, many when scans of several places are in one file, or the scanner stood elsewhere.
  double layered = 0.0;
};

/// Sorts points by the directions in which the scanner saw them. Points of an organized cloud keep
/// their rows; otherwise rows and columns are the scanner's own lines where it has any
/// (find_lines), and else even steps by how densely the points lie, with small gaps filled in along
/// a row. Where several points fall into a cell, the one nearest to its middle is taken. A scan all
/// around is closed by its first column or row once more. Clouds of more than two million cells are
/// thinned out. Points nearer than 5 cm are no returns.
GriddedCloud grid(const PointCloud& cloud);

}  // namespace marco::mapping3d
