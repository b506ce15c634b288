#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco {

/// Where SLAM says the robot is at a scan (lcmtypes/marco/slam_pose_t.lcm).
struct PoseEstimate {
  enum class Status {
    matched,
    predicted,  ///< no usable match: dead reckoned by odometry or the last velocity
    lost        ///< no pose in the map is known
  };

  Utime utime;
  Pose2 world_from_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta), world frame
  Status status = Status::predicted;
  double overlap = 0.0;  ///< part of the scan's points that found a wall
};

}  // namespace marco
