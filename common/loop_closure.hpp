#pragma once

#include <Eigen/Core>
#include <vector>

#include "lcm_tools/base/utime.hpp"

namespace marco {

/// A loop closure in force, as it lies in the map now.
struct LoopClosure {
  Utime from_utime;                                  ///< of the older keyframe
  Utime to_utime;                                    ///< of the newer one
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();  ///< robot at the older keyframe, world frame
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();    ///< the same at the newer one
  double residual_m = 0.0;    ///< from where the match saw the newer keyframe to where it lies
  double residual_rad = 0.0;  ///< the same of its heading, 0..pi
  double overlap = 0.0;       ///< of the match, 0..1
};

using LoopClosures = std::vector<LoopClosure>;

}  // namespace marco
