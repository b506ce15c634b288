#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bot_core/planar_lidar_t.hpp"
#include "common/grid_map.hpp"
#include "common/loop_closure.hpp"
#include "common/pose_estimate.hpp"
#include "common/samples.hpp"
#include "common/trajectory.hpp"
#include "common/wall.hpp"
#include "marco/grid_map_t.hpp"
#include "marco/imu_t.hpp"
#include "marco/lidar_raw_t.hpp"
#include "marco/line_map_t.hpp"
#include "marco/loop_closures_t.hpp"
#include "marco/odometry_t.hpp"
#include "marco/pantilt_state_t.hpp"
#include "marco/pose2_t.hpp"
#include "marco/sensor_info_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "marco/trajectory_t.hpp"

/// Message <-> value: one pair of functions per type, nowhere else. from_message throws
/// std::invalid_argument, naming the cause, when a message contradicts itself: a count below zero,
/// a stamp or pose that is not finite, a quaternion not of unit length. Ranges are passed on
/// unchanged: SensorInfo defines which of them are returns.
namespace marco {

bot_core::planar_lidar_t to_message(const LaserScan& regular_scan);
lidar_raw_t to_raw_message(const LaserScan& scan);
LaserScan from_message(const bot_core::planar_lidar_t& message, const std::string& channel);
LaserScan from_message(const lidar_raw_t& message, const std::string& channel);

sensor_info_t to_message(const SensorInfo& info);
SensorInfo from_message(const sensor_info_t& message);

odometry_t to_message(const OdometrySample& sample);
OdometrySample from_message(const odometry_t& message);

imu_t to_message(const ImuSample& sample);
ImuSample from_message(const imu_t& message);

pantilt_state_t to_message(const PanTiltState& state);
PanTiltState from_message(const pantilt_state_t& message);

pose2_t to_message(const TruePose& pose);
TruePose from_message(const pose2_t& message);

slam_pose_t to_message(const PoseEstimate& estimate);
PoseEstimate from_message(const slam_pose_t& message);

trajectory_t to_message(const Trajectory& trajectory, Utime utime, int64_t revision);
Trajectory from_message(const trajectory_t& message);

loop_closures_t to_message(const LoopClosures& loops, Utime utime, int64_t revision);
LoopClosures from_message(const loop_closures_t& message);

line_map_t to_message(const Walls& walls, Utime utime, int64_t revision);
Walls from_message(const line_map_t& message);

/// The grid in tiles of at most 256 x 256 cells (64 kB each), all of `revision`.
std::vector<grid_map_t> to_messages(const GridMap& map, Utime utime, int64_t revision);
GridMap from_message(const grid_map_t& message);

/// An encoded message with its channel.
struct EncodedMessage {
  std::string channel;
  Utime utime;
  std::vector<uint8_t> bytes;
};

template <class Message>
std::vector<uint8_t> encode_message(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// Nothing unless `bytes` are one message of this type, to the last byte.
template <class Message>
std::optional<Message> decode_message(std::span<const uint8_t> bytes) {
  Message message{};
  const int size = static_cast<int>(bytes.size());
  if (message.decode(bytes.data(), 0, size) != size) return std::nullopt;
  return message;
}

/// A value as the message, and on the channel, that Marco's processes expect.
EncodedMessage encode_sample(const Sample& sample);

/// The reverse; nothing for a channel or type without a Sample, or bytes that do not decode.
/// @throws std::invalid_argument as from_message.
std::optional<Sample> decode_sample(const std::string& channel, std::span<const uint8_t> bytes);

}  // namespace marco
