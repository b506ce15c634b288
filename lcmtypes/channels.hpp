#pragma once

#include <array>
#include <string>
#include <string_view>

#include "lcm_tools/lcmtypes/channels.hpp"

/// All channel names of Marco, with those of lcm_tools. The .lcm files next to this header define
/// the messages.
namespace marco::channels {

inline constexpr const char* kLidar =
    "LIDAR";  ///< bot_core.planar_lidar_t; LIDAR_<NAME> with several
inline constexpr const char* kLidarPattern = "LIDAR(_[A-Z0-9_]+)?";  ///< LIDAR_RAW... among them
inline constexpr const char* kLidarRaw = "LIDAR_RAW";  ///< lidar_raw_t; LIDAR_RAW_<NAME> likewise
inline constexpr const char* kSensorInfo = "SENSOR_INFO";
inline constexpr const char* kImu = "IMU";
inline constexpr const char* kOdometry = "ODOMETRY";
inline constexpr const char* kBaseCommand = "BASE_COMMAND";
inline constexpr const char* kBaseStatus = "BASE_STATUS";
inline constexpr const char* kSonar = "SONAR";
inline constexpr const char* kGamepad = "GAMEPAD";
inline constexpr const char* kPanTiltCommand = "PANTILT_COMMAND";
inline constexpr const char* kPanTiltState = "PANTILT_STATE";
inline constexpr const char* kCamera = "CAMERA";       ///< bot_core.image_t
inline constexpr const char* kTruePose = "TRUE_POSE";  ///< pose2_t
/// pose2_t whose stamps a reader brought into the laser's clock by the times of arrival
inline constexpr const char* kTruePoseByArrival = "TRUE_POSE_BY_ARRIVAL";
inline constexpr const char* kSlamPose = "SLAM_POSE";
inline constexpr const char* kGridMap = "GRID_MAP";
inline constexpr const char* kLineMap = "LINE_MAP";
inline constexpr const char* kTrajectory = "TRAJECTORY";
inline constexpr const char* kLoopClosures = "LOOP_CLOSURES";
inline constexpr const char* kScene = "SCENE";
inline constexpr const char* kMesh = "MESH";
inline constexpr const char* kSlamCommand = "SLAM_COMMAND";
inline constexpr const char* kSlamReply = "SLAM_REPLY";  ///< slam_reply_t
inline constexpr const char* kMapRequest = "MAP_REQUEST";
inline constexpr const char* kSimFault = "SIM_FAULT";  ///< sim_fault_t: orders to marco-sim

/// Orders to a robot. A player of recordings leaves these channels and kToolOrders out, or running
/// robots obey the recorded orders. GAMEPAD is among them since teleop turns it into orders.
inline constexpr std::array<std::string_view, 5> kRobotOrders = {kBaseCommand, kPanTiltCommand,
                                                                 kSlamCommand, kSimFault, kGamepad};

/// Whether scans on it are lidar_raw_t: LIDAR_RAW or LIDAR_RAW_<NAME>.
inline bool is_raw_lidar(std::string_view channel) {
  const std::string raw = kLidarRaw;
  return channel == raw || channel.starts_with(raw + "_");
}

/// The planar channel of the laser whose scans a channel carries, which its SENSOR_INFO names:
/// LIDAR_FRONT for both LIDAR_RAW_FRONT and LIDAR_FRONT.
inline std::string lidar_of(std::string_view channel) {
  if (!is_raw_lidar(channel)) return std::string(channel);
  return kLidar + std::string(channel.substr(std::string_view(kLidarRaw).size()));
}

/// The channel that carries a laser's scans with the time of every beam: LIDAR_RAW_FRONT for
/// LIDAR_FRONT, FRONT_RAW for a laser called FRONT.
inline std::string raw_channel_of(std::string_view lidar) {
  const std::string_view planar = kLidar;
  if (lidar != planar && !lidar.starts_with(std::string(planar) + "_")) {
    return std::string(lidar) + "_RAW";
  }
  return kLidarRaw + std::string(lidar.substr(planar.size()));
}

}  // namespace marco::channels
