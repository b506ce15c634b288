#pragma once

#include <optional>
#include <string>

#include "common/pose_buffer.hpp"
#include "common/samples.hpp"
#include "lcm_tools/log/log_info.hpp"
#include "web/foxglove/messages.hpp"

namespace marco::logs {

/// The tree of a log's frames: world -> odom -> robot -> each sensor, by the sensors' channels.
/// A frame has one parent, so with odometry SLAM's pose says where odom lies in the world; without,
/// where the robot does. Of several odometries or SLAMs the first one speaks.
class RobotFrames {
 public:
  /// @param log inspect_log of the log, without channels that are left out
  explicit RobotFrames(const LogInfo& log);

  /// odom -> robot.
  std::optional<foxglove::Transform> add_odometry(const std::string& channel,
                                                  Utime utime,
                                                  const Pose2& odom_from_robot);
  /// world -> odom, or world -> robot.
  std::optional<foxglove::Transform> add_slam(const std::string& channel,
                                              Utime utime,
                                              const Pose2& world_from_robot);
  /// robot -> the sensor's channel, or "plate" -> it for one on the pan-tilt.
  static foxglove::Transform of_sensor(const SensorInfo& info);
  /// robot -> "plate", the tilted plate. @param base the pan-tilt's own SENSOR_INFO
  static foxglove::Transform of_plate(const SensorInfo& base, const PanTiltState& state);

 private:
  std::string odometry_channel_;  // "" = the log has none
  std::string slam_channel_;      // "" = none spoke yet
  PoseBuffer odometry_;
};

}  // namespace marco::logs
