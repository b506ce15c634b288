#include "teleop/map_frame.hpp"

#include "common/robot_values.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::teleop {
namespace {

constexpr double kSilentS = 2.0;
// A pose is that of a scan, odometry may come a little later than it.
constexpr double kReachS = 0.2;

}  // namespace

void MapFrame::on_odometry(const OdometrySample& sample) {
  // From another origin: the pose before belongs to nothing any more.
  if (odometry_.restarts_at(sample)) {
    odometry_.clear();
    world_from_robot_.reset();
  }
  odometry_.add(sample);
}

void MapFrame::on_slam_pose(Utime utime, const std::optional<Pose2>& world_from_robot, Utime now) {
  pose_utime_ = utime;
  world_from_robot_ = world_from_robot;
  heard_ = now;
}

Pose2 MapFrame::odom_from_map(Utime now) const {
  require(heard_ != Utime{} && (now - heard_).seconds() <= kSilentS,
          "the pose on the map is unknown: no SLAM_POSE");
  require(world_from_robot_.has_value(), "the pose on the map is unknown: SLAM is lost");
  const auto odom_from_robot = odometry_.samples().at(pose_utime_, Duration::from_seconds(kReachS));
  require(odom_from_robot.has_value(), "no odometry, which a base needs to drive");
  return *odom_from_robot * world_from_robot_->inverse();
}

Eigen::Vector2d MapFrame::in_robot(const Eigen::Vector2d& odom_m, Utime now) const {
  const PoseBuffer& odometry = odometry_.samples();
  require(!odometry.empty() && (now - odometry.newest()).seconds() < kOrderHoldsS,
          "no odometry, which a base needs to drive");
  return odometry.newest_pose().inverse() * odom_m;
}

}  // namespace marco::teleop
