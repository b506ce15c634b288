#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/grid_map.hpp"
#include "common/pose_buffer.hpp"
#include "common/pose_estimate.hpp"
#include "common/samples.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "recordings/ros/messages.hpp"
#include "tools/bridge/marco_side.hpp"
#include "tools/bridge/ros_input.hpp"
#include "tools/bridge/websocket.hpp"
#include "web/foxglove/client.hpp"

namespace marco::bridge {

/// What SLAM says, published on a robot's ROS through its foxglove_bridge: /map, /slam_pose,
/// /marco/path, and the transform from map to odom on /tf. The path's topic is none that a planner
/// would follow.
class RosOutput {
 public:
  /// @param send  takes a message; false: too much waits already
  explicit RosOutput(std::function<bool(std::vector<uint8_t>)> send);

  /// @returns the text that announces its topics; nothing where the server takes none, and
  /// trouble() says why.
  std::optional<std::string> open(const foxglove::ServerInfo& server);
  void close() { encoding_.clear(); }
  const std::string& trouble() const { return trouble_; }
  /// The map once more, for who came late: what clients publish is not kept.
  void send_map_again();

  void note_frames(const RosInput::Frames& frames) { frames_ = frames; }
  /// What odometry says, for the transform.
  void note(const OdometrySample& odometry);

  void send_pose(const PoseEstimate& estimate);
  void send_map(const GridMap& map, Utime utime);
  void send_path(const Trajectory& path, Utime utime);

 private:
  void send(uint32_t channel, const std::vector<uint8_t>& payload);
  void send_transform(const PoseEstimate& estimate);

  std::function<bool(std::vector<uint8_t>)> send_;
  std::string encoding_;  // "" = nothing is sent
  std::string trouble_;
  std::optional<RosInput::Frames> frames_;
  PoseBuffer odometry_;
  std::optional<std::pair<GridMap, Utime>> map_;
};

/// A robot with ROS 1 or ROS 2, through its foxglove_bridge; ROS is not needed on this side.
class RosSide {
 public:
  /// @param drops  outlives it. @param say  a line for the user
  RosSide(const std::string& url,
          const RosOptions& options,
          process::DropCounter& drops,
          std::function<void(const std::string&)> say);

  /// The received sensors go to `marco`, which outlives the side.
  void connect(MarcoSide& marco) { marco_ = &marco; }

  /// Handles what the robot says; returns when `other` can be read, or after the time.
  void step(int other, int timeout_ms) { socket_.step(other, timeout_ms); }

  RosOutput& output() { return output_; }
  std::string state() const;

 private:
  void take_text(std::string_view text);
  void take_binary(std::span<const uint8_t> message);
  void count(const std::function<void()>& handle);

  std::string url_;
  process::DropCounter& drops_;
  std::function<void(const std::string&)> say_;
  MarcoSide* marco_ = nullptr;
  RosInput input_;
  RosOutput output_;
  std::string not_connected_ = "not connected yet";  // "" = connected
  WebSocketClient socket_;                           // last: its handlers use all of these
};

}  // namespace marco::bridge
