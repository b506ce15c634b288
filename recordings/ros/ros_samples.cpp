#include "recordings/ros/ros_samples.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/pose3.hpp"
#include "lcm_tools/base/check.hpp"
#include "recordings/rolled_wheels.hpp"
#include "recordings/ros/ros_scan.hpp"
#include "recordings/scan_bounds.hpp"

namespace marco::ros {
namespace {

Utime utime_of(int64_t ns) { return Utime::from_us(ns / 1000); }

}  // namespace

RosSamples::RosSamples(RosPlan plan, const RosOptions& options)
    : plan_(std::move(plan)), options_(options) {}

bool RosSamples::wants(const Topic& topic) const {
  const bool uses_tf = !plan_.odometry_parent.empty() || !plan_.joints.empty();
  if (uses_tf && use_of(topic) == Use::transforms) return true;
  const bool is_laser =
      std::any_of(plan_.lasers.begin(), plan_.lasers.end(),
                  [&topic](const LaserPlan& laser) { return laser.topic == topic.name; });
  return is_laser || plan_.uses_joints(topic.name) ||
         (!topic.name.empty() &&
          (topic.name == plan_.odometry_topic || topic.name == plan_.imu_topic ||
           topic.name == plan_.truth_topic));
}

std::vector<Sample> RosSamples::take(const Message& message) {
  samples_.clear();
  const std::string& topic = message.topic->name;
  const auto laser = std::find_if(plan_.lasers.begin(), plan_.lasers.end(),
                                  [&topic](const LaserPlan& one) { return one.topic == topic; });
  if (laser != plan_.lasers.end()) {
    take_scan(message, *laser);
  } else if (topic == plan_.odometry_topic) {
    take_odometry(message);
  } else if (topic == plan_.imu_topic) {
    take_imu(message);
  } else if (plan_.uses_joints(topic)) {
    take_joints(message);
  } else if (topic == plan_.truth_topic) {
    take_truth(message);
  } else {
    for (const TransformMessage& transform : decode_transforms(message)) {
      if (!transform.parent_from_child.translation().allFinite()) continue;
      take_transform(transform, message);
      take_joint(transform, message);
    }
  }
  return std::exchange(samples_, {});
}

Utime RosSamples::stamp_of(const Header& header,
                           const Message& message,
                           const std::string& key) const {
  if (header.stamp_ns == 0) return utime_of(message.received_ns + plan_.received_shift_ns);
  const auto shift = plan_.shift_ns.find(key);
  return utime_of(header.stamp_ns + (shift == plan_.shift_ns.end() ? 0 : shift->second));
}

void RosSamples::take_scan(const Message& message, const LaserPlan& laser) {
  LaserScan scan;
  if (laser.is_cloud) {
    const CloudMessage cloud = decode_cloud(message);
    scan = to_scan(cloud, laser, options_);
    scan.utime = stamp_of(cloud.header, message, laser.topic);
  } else {
    const LaserScanMessage raw = decode_scan(message);
    scan = to_scan(raw, laser, options_);
    const Utime begun = scan.utime;  // relative: what the stamped beam makes of 0
    scan.utime = stamp_of(raw.header, message, laser.topic) + (begun - Utime{});
  }
  require_scan(scan);
  // The first laser leads: what it is matched with begins with it.
  if (!announced_ && &laser != &plan_.lasers.front()) return;
  announce(scan.utime);
  samples_.emplace_back(std::move(scan));
}

void RosSamples::announce(Utime utime) {
  if (std::exchange(announced_, true)) return;
  if (plan_.pantilt) {
    plan_.pantilt->utime = utime;
    samples_.emplace_back(*plan_.pantilt);
  }
  for (LaserPlan& laser : plan_.lasers) {
    laser.info.utime = utime;
    samples_.emplace_back(laser.info);
  }
}

void RosSamples::take_odometry(const Message& message) {
  const OdometryMessage odometry = decode_odometry(message);
  require(odometry.pose.translation().allFinite(), "pose that is not finite");
  OdometrySample sample;
  sample.utime = stamp_of(odometry.header, message, plan_.odometry_topic);
  sample.odom_from_robot = flatten(odometry.pose);
  sample.velocity_m_per_s = odometry.linear.x();
  sample.yaw_rate_rad_per_s = odometry.angular.z();
  samples_.emplace_back(sample);
}

void RosSamples::take_transform(const TransformMessage& transform, const Message& message) {
  if (transform.header.frame_id != plan_.odometry_parent ||
      transform.child_frame_id != plan_.base_frame) {
    return;
  }
  const Utime utime = stamp_of(transform.header, message, kTfClock);
  if (utime == last_transform_) return;  // repeated by another publisher
  last_transform_ = utime;
  OdometrySample sample;
  sample.utime = utime;
  sample.odom_from_robot = flatten(transform.parent_from_child);
  samples_.emplace_back(sample);
}

void RosSamples::take_joint(const TransformMessage& transform, const Message& message) {
  for (const Joint& joint : plan_.joints) {
    if (transform.child_frame_id != joint.child) continue;
    const Eigen::Matrix3d& turn = transform.parent_from_child.linear();
    PanTiltState state;
    state.utime = stamp_of(transform.header, message, kJointClock);
    if (state.utime <= last_joint_) continue;
    last_joint_ = state.utime;
    state.pan_rad = std::atan2(turn(1, 0), turn(0, 0));
    state.tilt_rad = std::asin(std::clamp(turn(2, 0), -1.0, 1.0));
    samples_.emplace_back(state);
  }
}

void RosSamples::take_joints(const Message& message) {
  const JointStateMessage joints = decode_joints(message);
  const Utime utime = stamp_of(joints.header, message, message.topic->name);
  if (plan_.pantilt_joints && plan_.pantilt_joints->topic == message.topic->name) {
    bool is_told = false;
    for (std::size_t i = 0; i < joints.names.size(); ++i) {
      const bool pans = joints.names[i] == plan_.pantilt_joints->pan;
      const bool tilts = joints.names[i] == plan_.pantilt_joints->tilt;
      // About y, to the left: what tilts by a positive angle looks down.
      if (pans) pantilt_.pan_rad = joints.positions_rad[i];
      if (tilts) pantilt_.tilt_rad = -joints.positions_rad[i];
      is_told = is_told || pans || tilts;
    }
    pantilt_.utime = utime;
    require(std::isfinite(pantilt_.pan_rad + pantilt_.tilt_rad), "angle that is not finite");
    if (is_told) samples_.emplace_back(pantilt_);
  }
  if (plan_.wheels && plan_.wheels->topic == message.topic->name) take_wheels(joints, utime);
}

void RosSamples::take_wheels(const JointStateMessage& joints, Utime utime) {
  const auto angle_of = [&joints](const std::string& name) {
    const auto found = std::find(joints.names.begin(), joints.names.end(), name);
    return found == joints.names.end()
               ? std::nan("")
               : joints.positions_rad[static_cast<std::size_t>(found - joints.names.begin())];
  };
  const Eigen::Vector2d wheels_rad(angle_of(plan_.wheels->left), angle_of(plan_.wheels->right));
  if (wheels_rad.array().isNaN().any()) return;  // other joints of the robot
  require(wheels_rad.allFinite(), "angle that is not finite");
  const Eigen::Vector2d turned_rad = wheels_rad - wheels_rad_.value_or(wheels_rad);
  wheels_rad_ = wheels_rad;
  const Eigen::Vector2d way_m = options_.wheel_radius_m * turned_rad;
  odom_from_robot_ = odom_from_robot_ * rolled(way_m.x(), way_m.y(), options_.wheel_track_m);
  OdometrySample sample;
  sample.utime = utime;
  sample.odom_from_robot = odom_from_robot_;
  samples_.emplace_back(sample);
}

void RosSamples::take_imu(const Message& message) {
  const ImuMessage imu = decode_imu(message);
  if (!imu.has_angular_velocity) return;
  ImuSample sample;
  sample.utime = stamp_of(imu.header, message, plan_.imu_topic);
  sample.angular_velocity_rad_per_s =
      plan_.rad_per_imu_unit * (plan_.base_from_imu.linear() * imu.angular_velocity);
  if (imu.has_acceleration) {
    sample.acceleration_m_per_s2 = plan_.base_from_imu.linear() * imu.linear_acceleration;
  }
  samples_.emplace_back(sample);
}

void RosSamples::take_truth(const Message& message) {
  const PoseMessage pose = decode_pose(message);
  require(pose.pose.translation().allFinite(), "pose that is not finite");
  samples_.emplace_back(
      TruePose{stamp_of(pose.header, message, plan_.truth_topic), flatten(pose.pose)});
}

}  // namespace marco::ros
