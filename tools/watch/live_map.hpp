#pragma once

#include <optional>

#include "teleop/screen.hpp"
#include "viewer/picture.hpp"
#include "viewer/scene.hpp"

namespace marco::watch {

/// A growing map: tiles, path, robot. Has no clock, network or files.
class LiveMap {
 public:
  /// @throws std::invalid_argument as RobotView::add_tile.
  void add_tile(GridMap tile, int64_t revision) { view_.add_tile(std::move(tile), revision); }
  /// The newest SLAM pose; the path consists of these.
  void add_pose(Utime utime, const Pose2& world_from_robot);
  /// After an optimization: the keyframe poses replace the path up to the newest of them.
  void set_trajectory(const Trajectory& key_poses);

  /// @returns nothing before the first tile or path.
  std::optional<viewer::Scene> scene() const;
  std::size_t poses() const { return way_.size(); }

 private:
  teleop::RobotView view_;
  Trajectory way_;
};

}  // namespace marco::watch
