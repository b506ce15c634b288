#pragma once

#include <optional>

#include "common/input/odometry_track.hpp"
#include "common/samples.hpp"

namespace marco::teleop {

/// Where the map lies in the odometry frame: goals are given on the map, and bases drive by their
/// odometry. Known from the newest SLAM pose and the odometry at its time; it moves as SLAM
/// corrects the robot's pose. Not thread-safe.
class MapFrame {
 public:
  void on_odometry(const OdometrySample& sample);
  /// @param world_from_robot  nothing where SLAM is lost
  void on_slam_pose(Utime utime, const std::optional<Pose2>& world_from_robot, Utime now);

  /// Takes a pose in the map's frame into the odometry's.
  /// @throws std::invalid_argument that says what is missing: SLAM is silent for 2 s or lost, or no
  /// odometry covers its pose.
  Pose2 odom_from_map(Utime now) const;
  /// A point of the odometry's frame as the robot sees it now [m].
  /// @throws std::invalid_argument where no odometry came for as long as an order to move holds.
  Eigen::Vector2d in_robot(const Eigen::Vector2d& odom_m, Utime now) const;
  const PoseBuffer& odometry() const { return odometry_.samples(); }

 private:
  OdometryTrack odometry_;
  Utime pose_utime_;
  Utime heard_;
  std::optional<Pose2> world_from_robot_;
};

}  // namespace marco::teleop
