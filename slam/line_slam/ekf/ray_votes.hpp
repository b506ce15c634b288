#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/line_slam/ekf/wall_evidence.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::slam {

/// Each ray of a scan votes on the piece of a wall that it meets: hit where it ends on the wall,
/// passed where it ends behind the wall, nothing where it ends in front or grazes the wall.
/// @param wall_in_robot  x1 y1 x2 y2. @param pose_margin_m  added to the margin of a hit.
void vote_by_rays(const ScanInRobot& scan,
                  const Eigen::Vector4d& wall_in_robot,
                  double pose_margin_m,
                  WallEvidence& evidence);

/// A wall that a scan may have seen.
struct WallSeen {
  Eigen::Vector4d in_robot;  ///< x1 y1 x2 y2
  WallEvidence* evidence;
};

/// The same for poses known to centimetres: of walls that face the same way, only the one nearest
/// to where a ray ends is hit; the others are passed. Two surfaces one behind the other are never
/// both seen.
void vote_for_nearest(const ScanInRobot& scan, const std::vector<WallSeen>& walls);

}  // namespace marco::slam
