#pragma once

#include "common/round_wall.hpp"
#include "common/wall.hpp"

namespace marco {

/// Where two walls of a line map meet: derived from them, no estimate of its own.
struct CornerPoint {
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();        ///< world frame
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< [m^2]
  int64_t wall_ids[2] = {0, 0};  ///< the one that ends here, then the one that begins here
  bool convex = false;           ///< juts into the free space, as the edge of a pillar does
};

using CornerPoints = std::vector<CornerPoint>;

/// What the line SLAM finds, world frame.
struct LineMap {
  Walls walls;
  RoundWalls round_walls;
  CornerPoints corners;
};

}  // namespace marco
