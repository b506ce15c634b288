#pragma once

#include <span>
#include <vector>

#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// Whether something covers the laser, a hand or people all around: most returns are near, where
/// the last keyframes saw free space. Such scans fit each other and nothing else: within three of
/// them a map is spoiled.
/// @param world_from_robot  where the robot may be: as predicted, and where it was. All must agree,
/// for at a wrong place walls stand in free space, too.
/// @param keys  the map; empty: false
/// @param was_covered  in the scan before. A robot that drives on under a cover leaves the space
/// that was seen as free. So the cover lasts until the laser sees farther, or sees known walls.
bool laser_is_covered(const Points2& hits_in_robot,
                      const Eigen::Vector2d& sensor_in_robot,
                      std::span<const Pose2> world_from_robot,
                      const std::vector<Keyframe>& keys,
                      bool was_covered);

}  // namespace marco::slam
