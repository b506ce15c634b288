#pragma once

#include <optional>

#include "teleop/screen.hpp"
#include "viewer/picture.hpp"
#include "viewer/scene.hpp"

namespace marco::watch {

/// The map as it grows: tiles, the way so far, the robot. Without clock, network and files.
class LiveMap {
 public:
  /// @throws std::invalid_argument as RobotView::add_tile.
  void add_tile(GridMap tile, int64_t revision) { view_.add_tile(std::move(tile), revision); }
  /// SLAM's pose of the robot; the way is made of those.
  void add_pose(Utime utime, const Pose2& world_from_robot);
  /// SLAM set all its key poses anew: they replace the way up to the newest of them.
  void set_trajectory(const Trajectory& key_poses);

  /// @returns nothing before there is anything to see.
  std::optional<viewer::Scene> scene() const;
  std::size_t poses() const { return way_.size(); }

 private:
  teleop::RobotView view_;
  Trajectory way_;
};

/// All tiles, of one resolution, in one grid. @returns nothing for none.
std::optional<GridMap> join_tiles(const std::map<std::pair<double, double>, GridMap>& tiles);

}  // namespace marco::watch
