#include "lcmtypes/convert.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/field_copy.hpp"
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

constexpr auto kSensorInfoFields = [](auto copy, auto& info, auto& message) {
  copy(info.channel, message.channel);
  for (int i = 0; i < 3; ++i) copy(info.tilt_axis_m(i), message.tilt_axis_m[i]);
  copy(info.scan_duration_s, message.scan_duration_s);
  copy(info.range_min_m, message.range_min_m);
  copy(info.range_max_m, message.range_max_m);
  copy(info.range_sigma_m, message.range_sigma_m);
  copy(info.focal_length_px, message.focal_length_px);
};

constexpr auto kOdometryFields = [](auto copy, auto& sample, auto& message) {
  copy(sample.odom_from_robot.x_m, message.x_m);
  copy(sample.odom_from_robot.y_m, message.y_m);
  copy(sample.odom_from_robot.theta_rad, message.theta_rad);
  copy(sample.velocity_m_per_s, message.velocity_m_per_s);
  copy(sample.yaw_rate_rad_per_s, message.yaw_rate_rad_per_s);
  copy(sample.left_clicks, message.left_clicks);
  copy(sample.right_clicks, message.right_clicks);
};

constexpr auto kImuFields = [](auto copy, auto& sample, auto& message) {
  for (int i = 0; i < 3; ++i) {
    copy(sample.angular_velocity_rad_per_s(i), message.angular_velocity_rad_per_s[i]);
    copy(sample.acceleration_m_per_s2(i), message.acceleration_m_per_s2[i]);
  }
};

constexpr auto kPanTiltFields = [](auto copy, auto& state, auto& message) {
  copy(state.pan_rad, message.pan_rad);
  copy(state.tilt_rad, message.tilt_rad);
  copy(state.pan_rate_rad_per_s, message.pan_rate_rad_per_s);
  copy(state.tilt_rate_rad_per_s, message.tilt_rate_rad_per_s);
};

constexpr auto kPose2Fields = [](auto copy, auto& pose, auto& message) {
  copy(pose.world_from_robot.x_m, message.x_m);
  copy(pose.world_from_robot.y_m, message.y_m);
  copy(pose.world_from_robot.theta_rad, message.theta_rad);
};

// @param channel  of a scan, whose message does not name it
template <class Message, class... Channel>
std::optional<Sample> decode_as(std::span<const uint8_t> bytes, const Channel&... channel) {
  const auto message = decode_message<Message>(bytes);
  if (!message) return std::nullopt;
  return from_message(*message, channel...);
}

}  // namespace

bot_core::planar_lidar_t to_message(const LaserScan& scan) {
  require(scan.bearings_rad.empty() && scan.time_offsets_s.empty(),
          "planar_lidar_t cannot carry beams with individual bearings or times");
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
  auto message = message_of<sensor_info_t>(info, kSensorInfoFields);
  message.mount = info.mount == SensorInfo::Mount::robot ? sensor_info_t::MOUNT_ROBOT
                                                         : sensor_info_t::MOUNT_PANTILT;
  copy(info.parent_from_sensor, message.parent_from_sensor_m, message.parent_from_sensor_quat);
  return message;
}

SensorInfo from_message(const sensor_info_t& message) {
  auto info = value_of<SensorInfo>(message, kSensorInfoFields);
  const bool on_robot = message.mount == sensor_info_t::MOUNT_ROBOT;
  require(on_robot || message.mount == sensor_info_t::MOUNT_PANTILT,
          "sensor_info_t: unknown mount");
  info.mount = on_robot ? SensorInfo::Mount::robot : SensorInfo::Mount::pantilt;
  info.parent_from_sensor =
      pose_from(message.parent_from_sensor_m, message.parent_from_sensor_quat);
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
  return message_of<odometry_t>(sample, kOdometryFields);
}
OdometrySample from_message(const odometry_t& message) {
  auto sample = value_of<OdometrySample>(message, kOdometryFields);
  sample.odom_from_robot = finite_pose(message.x_m, message.y_m, message.theta_rad,
                                       "odometry_t: the pose is not finite or too far away");
  return sample;
}

imu_t to_message(const ImuSample& sample) { return message_of<imu_t>(sample, kImuFields); }
ImuSample from_message(const imu_t& message) {
  auto sample = value_of<ImuSample>(message, kImuFields);
  require(sample.angular_velocity_rad_per_s.allFinite(), "imu_t: a rate is not finite");
  return sample;
}

pantilt_state_t to_message(const PanTiltState& state) {
  return message_of<pantilt_state_t>(state, kPanTiltFields);
}
PanTiltState from_message(const pantilt_state_t& message) {
  auto state = value_of<PanTiltState>(message, kPanTiltFields);
  require(std::isfinite(state.pan_rad) && std::isfinite(state.tilt_rad),
          "pantilt_state_t: an angle is not finite");
  return state;
}

pose2_t to_message(const TruePose& pose) { return message_of<pose2_t>(pose, kPose2Fields); }
TruePose from_message(const pose2_t& message) {
  return {stamp_of(message.utime), finite_pose(message.x_m, message.y_m, message.theta_rad,
                                               "pose2_t: the pose is not finite or too far away")};
}

EncodedMessage encode_sample(const Sample& sample) {
  // In the order of the Sample's types; a scan names its channel itself.
  static constexpr const char* kChannels[] = {channels::kSensorInfo,   nullptr,
                                              channels::kOdometry,     channels::kImu,
                                              channels::kPanTiltState, channels::kTruePose};
  if (const auto* scan = std::get_if<LaserScan>(&sample)) {
    const bool regular = scan->bearings_rad.empty() && scan->time_offsets_s.empty();
    return {scan->channel, scan->utime,
            regular ? encode_message(to_message(*scan)) : encode_message(to_raw_message(*scan))};
  }
  const auto* truth = std::get_if<TruePose>(&sample);
  const char* const channel = truth != nullptr && truth->is_by_arrival
                                  ? channels::kTruePoseByArrival
                                  : kChannels[sample.index()];
  return std::visit(
      [channel](const auto& value) -> EncodedMessage {
        return {channel, value.utime, encode_message(to_message(value))};
      },
      sample);
}

std::optional<Sample> decode_sample(const std::string& channel, std::span<const uint8_t> bytes) {
  if (channel == channels::kSensorInfo) return decode_as<sensor_info_t>(bytes);
  if (channel == channels::kOdometry) return decode_as<odometry_t>(bytes);
  if (channel == channels::kImu) return decode_as<imu_t>(bytes);
  if (channel == channels::kPanTiltState) return decode_as<pantilt_state_t>(bytes);
  if (channel == channels::kTruePose) return decode_as<pose2_t>(bytes);
  if (channel == channels::kTruePoseByArrival) {
    std::optional<Sample> truth = decode_as<pose2_t>(bytes);
    if (truth) std::get<TruePose>(*truth).is_by_arrival = true;
    return truth;
  }
  if (channel.rfind(channels::kLidar, 0) == 0) {
    if (auto scan = decode_as<bot_core::planar_lidar_t>(bytes, channel)) return scan;
    return decode_as<lidar_raw_t>(bytes, channel);
  }
  return std::nullopt;
}

}  // namespace marco
