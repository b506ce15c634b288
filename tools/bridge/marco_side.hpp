#pragma once

#include <functional>
#include <map>
#include <string>

#include "common/pose_estimate.hpp"
#include "common/samples.hpp"
#include "common/trajectory.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "teleop/screen.hpp"

namespace marco::bridge {

/// The side of Marco's programs: receives a robot's sensors, and returns SLAM's results.
class MarcoSide {
 public:
  struct Listener {
    std::function<void(const PoseEstimate&)> pose;
    std::function<void(const GridMap&, Utime)> map;
    std::function<void(const Trajectory&, Utime)> path;
  };

  /// @param bus, drops  outlive it.
  MarcoSide(process::LcmBus& bus, process::DropCounter& drops, Listener listener);

  void give(const Sample& sample);
  /// SLAM forgets its map. @param retain_pose  the new one begins where the robot is
  enum class Reset { everything, map_only };
  void reset(Reset what);

  /// Announces the sensors once a second, and reports a map when all its tiles have arrived.
  /// @param now_s  of any clock that never steps back
  void tick(double now_s);

  int64_t scans() const { return scans_; }
  int64_t odometry() const { return odometry_; }
  int64_t poses() const { return poses_; }
  int64_t maps() const { return maps_; }

 private:
  void subscribe();
  void publish(const Sample& sample);

  process::LcmBus& bus_;
  process::DropCounter& drops_;
  Listener listener_;
  std::map<std::string, SensorInfo> sensors_;
  teleop::RobotView view_;
  Pose2 world_from_robot_;
  Utime newest_tile_;
  bool has_new_tiles_ = false, tiles_came_ = false;
  double tiles_since_s_ = 0.0, announced_s_ = 0.0;
  int64_t scans_ = 0, odometry_ = 0, poses_ = 0, maps_ = 0;
};

}  // namespace marco::bridge
