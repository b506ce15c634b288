#include "tools/log/robot_frames.hpp"

#include "marco/mbot_pose2d_t.hpp"
#include "marco/odometry_t.hpp"

namespace marco::logs {

RobotFrames::RobotFrames(const LogInfo& log) {
  const auto holds = [](const ChannelInfo& channel, int64_t fingerprint) {
    return channel.types.contains(static_cast<uint64_t>(fingerprint));
  };
  for (const ChannelInfo& channel : log.channels) {
    const bool is_odometry =
        holds(channel, odometry_t::getHash()) || (holds(channel, mbot_pose2d_t::getHash()) &&
                                                  channel.name.find("ODOM") != std::string::npos);
    if (is_odometry && odometry_channel_.empty()) odometry_channel_ = channel.name;
  }
}

std::optional<foxglove::Transform> RobotFrames::add_odometry(const std::string& channel,
                                                             Utime utime,
                                                             const Pose2& odom_from_robot) {
  if (channel != odometry_channel_) return std::nullopt;
  odometry_.add(utime, odom_from_robot);
  return foxglove::Transform{"odom", "robot", lift(odom_from_robot)};
}

std::optional<foxglove::Transform> RobotFrames::add_slam(const std::string& channel,
                                                         Utime utime,
                                                         const Pose2& world_from_robot) {
  if (slam_channel_.empty()) slam_channel_ = channel;
  if (channel != slam_channel_) return std::nullopt;
  if (odometry_channel_.empty())
    return foxglove::Transform{"world", "robot", lift(world_from_robot)};
  if (odometry_.empty()) return std::nullopt;
  // Of another clock the newest is the best there is.
  constexpr Duration kReach = Duration::from_us(200000);
  const Pose2 odom_from_robot = odometry_.at(utime, kReach).value_or(odometry_.newest_pose());
  return foxglove::Transform{"world", "odom", lift(world_from_robot * odom_from_robot.inverse())};
}

foxglove::Transform RobotFrames::of_sensor(const SensorInfo& info) {
  const bool on_robot = info.mount == SensorInfo::Mount::robot;
  return {on_robot ? "robot" : "plate", info.channel, info.parent_from_sensor};
}

foxglove::Transform RobotFrames::of_plate(const SensorInfo& base, const PanTiltState& state) {
  SensorInfo plate;
  return {"robot", "plate", robot_from_pantilt_sensor(base, plate, state.pan_rad, state.tilt_rad)};
}

}  // namespace marco::logs
