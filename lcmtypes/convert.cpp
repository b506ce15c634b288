#include "lcmtypes/convert.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/finite_pose.hpp"
#include "lcmtypes/stamp.hpp"

namespace marco {
namespace {

void copy(const Pose3& pose, double (&translation)[3], double (&quaternion)[4]) {
  const Eigen::Quaterniond q(pose.linear());
  for (int i = 0; i < 3; ++i) translation[i] = pose.translation()(i);
  quaternion[0] = q.w();
  quaternion[1] = q.x();
  quaternion[2] = q.y();
  quaternion[3] = q.z();
}

Pose3 pose_from(const double (&translation)[3], const double (&quaternion)[4]) {
  const Eigen::Quaterniond q(quaternion[0], quaternion[1], quaternion[2], quaternion[3]);
  require(std::abs(q.norm() - 1.0) < 1e-3, "sensor_info_t: quaternion is not of unit length");
  Pose3 pose = Pose3::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(translation[0], translation[1], translation[2]);
  return pose;
}

template <class Message>
std::optional<Sample> decode_as(std::span<const uint8_t> bytes) {
  Message message{};
  const int size = static_cast<int>(bytes.size());
  if (message.decode(bytes.data(), 0, size) != size) return std::nullopt;
  return from_message(message);
}

template <class Message>
std::optional<Sample> decode_scan_as(std::span<const uint8_t> bytes, const std::string& channel) {
  Message message{};
  const int size = static_cast<int>(bytes.size());
  if (message.decode(bytes.data(), 0, size) != size) return std::nullopt;
  return from_message(message, channel);
}

}  // namespace

bot_core::planar_lidar_t to_message(const LaserScan& scan) {
  require(scan.bearings_rad.empty() && scan.time_offsets_s.empty(),
          "planar_lidar_t cannot carry beams with bearings or times of their own");
  bot_core::planar_lidar_t message;
  message.utime = scan.utime.us;
  message.nranges = static_cast<int32_t>(scan.ranges_m.size());
  message.ranges = scan.ranges_m;
  message.nintensities = 0;
  message.rad0 = static_cast<float>(scan.first_bearing_rad);
  message.radstep = static_cast<float>(scan.bearing_step_rad);
  return message;
}

LaserScan from_message(const bot_core::planar_lidar_t& message, const std::string& channel) {
  require(message.nranges >= 0, "planar_lidar_t: nranges below 0");
  require(std::isfinite(message.rad0) && std::isfinite(message.radstep),
          "planar_lidar_t: rad0 or radstep is not finite");
  LaserScan scan;
  scan.utime = stamp_of(message.utime);
  scan.channel = channel;
  scan.ranges_m = message.ranges;
  scan.first_bearing_rad = static_cast<double>(message.rad0);
  scan.bearing_step_rad = static_cast<double>(message.radstep);
  return scan;
}

lidar_raw_t to_raw_message(const LaserScan& scan) {
  lidar_raw_t message;
  const std::size_t count = scan.size();
  message.utime = scan.utime.us;
  message.num_ranges = static_cast<int32_t>(count);
  message.ranges = scan.ranges_m;
  message.intensities.assign(count, 0.0F);
  message.thetas.resize(count);
  message.times.resize(count);
  for (std::size_t beam = 0; beam < count; ++beam) {
    message.thetas[beam] = static_cast<float>(scan.bearing_rad(beam));
    const double offset_s =
        scan.time_offsets_s.empty() ? 0.0 : static_cast<double>(scan.time_offsets_s[beam]);
    message.times[beam] = (scan.utime + Duration::from_seconds(offset_s)).us;
  }
  return message;
}

LaserScan from_message(const lidar_raw_t& message, const std::string& channel) {
  require(message.num_ranges >= 0, "lidar_raw_t: num_ranges below 0");
  LaserScan scan;
  scan.utime = stamp_of(message.utime);
  scan.channel = channel;
  scan.ranges_m = message.ranges;
  scan.bearings_rad = message.thetas;
  require(std::all_of(message.thetas.begin(), message.thetas.end(),
                      [](float bearing) { return std::isfinite(bearing); }),
          "lidar_raw_t: a bearing is not finite");
  scan.time_offsets_s.reserve(message.times.size());
  for (const int64_t time : message.times) {
    scan.time_offsets_s.push_back(static_cast<float>((stamp_of(time) - scan.utime).seconds()));
  }
  return scan;
}

sensor_info_t to_message(const SensorInfo& info) {
  sensor_info_t message;
  message.utime = info.utime.us;
  message.channel = info.channel;
  message.mount = info.mount == SensorInfo::Mount::robot ? sensor_info_t::MOUNT_ROBOT
                                                         : sensor_info_t::MOUNT_PANTILT;
  copy(info.parent_from_sensor, message.parent_from_sensor_m, message.parent_from_sensor_quat);
  for (int i = 0; i < 3; ++i) message.tilt_axis_m[i] = info.tilt_axis_m(i);
  message.scan_duration_s = info.scan_duration_s;
  message.range_min_m = info.range_min_m;
  message.range_max_m = info.range_max_m;
  message.range_sigma_m = info.range_sigma_m;
  message.focal_length_px = info.focal_length_px;
  return message;
}

SensorInfo from_message(const sensor_info_t& message) {
  SensorInfo info;
  info.utime = stamp_of(message.utime);
  info.channel = message.channel;
  require(
      message.mount == sensor_info_t::MOUNT_ROBOT || message.mount == sensor_info_t::MOUNT_PANTILT,
      "sensor_info_t: unknown mount");
  info.mount = message.mount == sensor_info_t::MOUNT_ROBOT ? SensorInfo::Mount::robot
                                                           : SensorInfo::Mount::pantilt;
  info.parent_from_sensor =
      pose_from(message.parent_from_sensor_m, message.parent_from_sensor_quat);
  info.tilt_axis_m =
      Eigen::Vector3d(message.tilt_axis_m[0], message.tilt_axis_m[1], message.tilt_axis_m[2]);
  info.scan_duration_s = message.scan_duration_s;
  info.range_min_m = message.range_min_m;
  info.range_max_m = message.range_max_m;
  info.range_sigma_m = message.range_sigma_m;
  info.focal_length_px = message.focal_length_px;
  // The longest arm of an excavator; no robot that maps a building is larger.
  constexpr double kFarthestMountM = 20.0;
  require(info.parent_from_sensor.translation().norm() <= kFarthestMountM,
          "sensor_info_t: a sensor more than 20 m from its robot");
  require(info.tilt_axis_m.norm() <= kFarthestMountM,
          "sensor_info_t: a tilt axis more than 20 m from its pan axis");
  require(info.range_max_m > info.range_min_m && info.range_min_m >= 0.0,
          "sensor_info_t: range_max_m must exceed range_min_m >= 0");
  require(info.scan_duration_s >= 0.0 && info.scan_duration_s < 10.0,
          "sensor_info_t: scan_duration_s outside 0..10");
  return info;
}

odometry_t to_message(const OdometrySample& sample) {
  odometry_t message;
  message.utime = sample.utime.us;
  message.x_m = sample.odom_from_robot.x_m;
  message.y_m = sample.odom_from_robot.y_m;
  message.theta_rad = sample.odom_from_robot.theta_rad;
  message.velocity_m_per_s = sample.velocity_m_per_s;
  message.yaw_rate_rad_per_s = sample.yaw_rate_rad_per_s;
  message.left_clicks = sample.left_clicks;
  message.right_clicks = sample.right_clicks;
  return message;
}

OdometrySample from_message(const odometry_t& message) {
  OdometrySample sample;
  sample.utime = stamp_of(message.utime);
  sample.odom_from_robot =
      finite_pose(message.x_m, message.y_m, message.theta_rad, "odometry_t: pose is no place");
  sample.velocity_m_per_s = message.velocity_m_per_s;
  sample.yaw_rate_rad_per_s = message.yaw_rate_rad_per_s;
  sample.left_clicks = message.left_clicks;
  sample.right_clicks = message.right_clicks;
  return sample;
}

imu_t to_message(const ImuSample& sample) {
  imu_t message;
  message.utime = sample.utime.us;
  for (int i = 0; i < 3; ++i) {
    message.angular_velocity_rad_per_s[i] = sample.angular_velocity_rad_per_s(i);
    message.acceleration_m_per_s2[i] = sample.acceleration_m_per_s2(i);
  }
  return message;
}

ImuSample from_message(const imu_t& message) {
  ImuSample sample;
  sample.utime = stamp_of(message.utime);
  sample.angular_velocity_rad_per_s = Eigen::Vector3d(message.angular_velocity_rad_per_s);
  sample.acceleration_m_per_s2 = Eigen::Vector3d(message.acceleration_m_per_s2);
  require(sample.angular_velocity_rad_per_s.allFinite(), "imu_t: a rate is not finite");
  return sample;
}

pantilt_state_t to_message(const PanTiltState& state) {
  pantilt_state_t message;
  message.utime = state.utime.us;
  message.pan_rad = state.pan_rad;
  message.tilt_rad = state.tilt_rad;
  message.pan_rate_rad_per_s = state.pan_rate_rad_per_s;
  message.tilt_rate_rad_per_s = state.tilt_rate_rad_per_s;
  return message;
}

PanTiltState from_message(const pantilt_state_t& message) {
  PanTiltState state;
  state.utime = stamp_of(message.utime);
  state.pan_rad = message.pan_rad;
  state.tilt_rad = message.tilt_rad;
  state.pan_rate_rad_per_s = message.pan_rate_rad_per_s;
  state.tilt_rate_rad_per_s = message.tilt_rate_rad_per_s;
  require(std::isfinite(state.pan_rad) && std::isfinite(state.tilt_rad),
          "pantilt_state_t: an angle is not finite");
  return state;
}

pose2_t to_message(const TruePose& pose) {
  pose2_t message;
  message.utime = pose.utime.us;
  message.x_m = pose.world_from_robot.x_m;
  message.y_m = pose.world_from_robot.y_m;
  message.theta_rad = pose.world_from_robot.theta_rad;
  return message;
}

TruePose from_message(const pose2_t& message) {
  return {stamp_of(message.utime),
          finite_pose(message.x_m, message.y_m, message.theta_rad, "pose2_t: pose is no place")};
}

EncodedMessage encode_sample(const Sample& sample) {
  struct Encoder {
    EncodedMessage operator()(const SensorInfo& info) const {
      return {channels::kSensorInfo, info.utime, encode_message(to_message(info))};
    }
    EncodedMessage operator()(const LaserScan& scan) const {
      const bool regular = scan.bearings_rad.empty() && scan.time_offsets_s.empty();
      return {scan.channel, scan.utime,
              regular ? encode_message(to_message(scan)) : encode_message(to_raw_message(scan))};
    }
    EncodedMessage operator()(const OdometrySample& odometry) const {
      return {channels::kOdometry, odometry.utime, encode_message(to_message(odometry))};
    }
    EncodedMessage operator()(const ImuSample& imu) const {
      return {channels::kImu, imu.utime, encode_message(to_message(imu))};
    }
    EncodedMessage operator()(const PanTiltState& state) const {
      return {channels::kPanTiltState, state.utime, encode_message(to_message(state))};
    }
    EncodedMessage operator()(const TruePose& pose) const {
      return {channels::kTruePose, pose.utime, encode_message(to_message(pose))};
    }
  };
  return std::visit(Encoder{}, sample);
}

std::optional<Sample> decode_sample(const std::string& channel, std::span<const uint8_t> bytes) {
  if (channel == channels::kSensorInfo) return decode_as<sensor_info_t>(bytes);
  if (channel == channels::kOdometry) return decode_as<odometry_t>(bytes);
  if (channel == channels::kImu) return decode_as<imu_t>(bytes);
  if (channel == channels::kPanTiltState) return decode_as<pantilt_state_t>(bytes);
  if (channel == channels::kTruePose) return decode_as<pose2_t>(bytes);
  if (channel.rfind(channels::kLidar, 0) == 0) {
    if (auto scan = decode_scan_as<bot_core::planar_lidar_t>(bytes, channel)) return scan;
    return decode_scan_as<lidar_raw_t>(bytes, channel);
  }
  return std::nullopt;
}

}  // namespace marco
