#pragma once

#include "common/covariance.hpp"

namespace marco::slam {

/// Where the robot is in the map.
struct PoseWithCovariance {
  Pose2 world_from_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta), world frame

  template <class Visitor>
  void visit(Visitor& v) {
    v("world_from_robot", world_from_robot);
    v("covariance", covariance);
  }
};

/// Dead reckoning: the estimate after a move. Its uncertainty is that of the pose before, with a
/// wrong heading there carrying the move aside, and the move's own.
/// @param covariance  of before_from_now, in the frame before
inline PoseWithCovariance dead_reckoned(const PoseWithCovariance& before,
                                        const Pose2& before_from_now,
                                        const Eigen::Matrix3d& covariance) {
  const Pose2 now = before.world_from_robot * before_from_now;
  return {now, carried_along(before.covariance, before.world_from_robot, now) +
                   rotated(covariance, before.world_from_robot.theta_rad)};
}

}  // namespace marco::slam
