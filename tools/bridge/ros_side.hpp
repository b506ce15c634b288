#pragma once

#include <functional>
#include <string>

#include "lcm_tools/process/drop_counter.hpp"
#include "tools/bridge/marco_side.hpp"
#include "tools/bridge/ros_input.hpp"
#include "tools/bridge/ros_output.hpp"
#include "tools/bridge/websocket.hpp"

namespace marco::bridge {

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
