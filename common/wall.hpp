#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace marco {

/// A straight piece of wall, directed: free space lies on the left of `start` -> `end`.
struct Wall {
  int64_t id = 0;  ///< of the map; pieces of one wall (a door between them) share it
  Eigen::Vector2d start_m = Eigen::Vector2d::Zero();  ///< world frame
  Eigen::Vector2d end_m = Eigen::Vector2d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of (start x, y, end x, y) [m^2]
  double existence = 1.0;   ///< probability that it stands there now, 0..1
  int64_t times_seen = 0;   ///< scans that it was found in
  bool start_seen = false;  ///< whether the end was seen as a corner or an edge, not only cut off
  bool end_seen = false;

  double length_m() const { return (end_m - start_m).norm(); }
};

using Walls = std::vector<Wall>;

}  // namespace marco
