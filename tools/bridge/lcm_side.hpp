#pragma once

#include <string>

#include "common/pose_estimate.hpp"
#include "common/trajectory.hpp"
#include "live/foreign_bus.hpp"
#include "tools/bridge/marco_side.hpp"

namespace marco::bridge {

/// Another stack on an LCM network of its own. Its scans and odometry are read by the table of
/// foreign channels; what SLAM says is sent in the types of the stack whose messages came: MBot's,
/// or dimos' (ROS' structs).
class LcmSide {
 public:
  /// @param bus  the other network; outlives it.
  LcmSide(process::LcmBus& bus, ForeignTable table, std::function<void(const std::string&)> say);

  /// The received sensors go to `marco`, which outlives the side.
  void connect(MarcoSide& marco);

  void send_pose(const PoseEstimate& estimate);
  void send_map(const GridMap& map, Utime utime);
  void send_path(const Trajectory& path, Utime utime);

  /// For PROCESS_STATUS: whose messages come, or that none do.
  std::string state() const;
  const process::DropCounter& drops() const { return drops_; }

 private:
  enum class Stack { none, mbot, dimos, other };
  Stack stack() const;

  process::LcmBus& bus_;
  ForeignBus sensors_;
  process::DropCounter drops_;
  Duration behind_;  ///< how far that network's clock is behind ours, with the way here
  int32_t sequence_ = 0;
};

}  // namespace marco::bridge
