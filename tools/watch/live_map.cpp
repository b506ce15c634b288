#include "tools/watch/live_map.hpp"

#include <limits>

#include "common/map_tiles.hpp"

namespace marco::watch {

void LiveMap::add_pose(Utime utime, const Pose2& world_from_robot) {
  if (!way_.empty() && utime <= way_.back().utime) return;
  way_.push_back({utime, world_from_robot});
}

void LiveMap::set_trajectory(const Trajectory& key_poses) {
  if (key_poses.empty()) return;
  Trajectory joined = key_poses;
  for (const auto& pose : way_) {
    if (pose.utime > key_poses.back().utime) joined.push_back(pose);
  }
  way_ = std::move(joined);
}

std::optional<viewer::Scene> LiveMap::scene() const {
  viewer::Scene scene;
  std::vector<const GridMap*> tiles;
  for (const auto& [origin, tile] : view_.map_tiles) tiles.push_back(&tile);
  scene.grid = join_tiles(tiles, std::numeric_limits<double>::infinity());
  if (!scene.grid && way_.size() < 2) return std::nullopt;
  if (!way_.empty()) {
    // SLAM keeps few poses of old parts: lines between them would cross walls.
    constexpr double kLongestStepM = 1.0;
    scene.paths.push_back({way_, viewer::palette::kEstimate, "way", kLongestStepM});
    viewer::RobotItem robot;
    robot.world_from_robot = way_.back().world_from_robot;
    scene.robots.push_back(robot);
  }
  return scene;
}

}  // namespace marco::watch
