#pragma once

#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco {

struct StampedPose2 {
  Utime utime;
  Pose2 world_from_robot;
};

/// Poses in the order of their scans (stamps of some logs step backwards).
using Trajectory = std::vector<StampedPose2>;

}  // namespace marco
