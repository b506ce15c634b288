#pragma once

#include <Eigen/Core>

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

}  // namespace marco::slam
