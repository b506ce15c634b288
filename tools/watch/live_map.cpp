#include "tools/watch/live_map.hpp"

#include <algorithm>

namespace marco::watch {

std::optional<GridMap> join_tiles(const std::map<std::pair<double, double>, GridMap>& tiles) {
  if (tiles.empty()) return std::nullopt;
  GridMap all;
  all.resolution_m = tiles.begin()->second.resolution_m;
  Eigen::Vector2d min_m = Eigen::Vector2d::Constant(HUGE_VAL), max_m = -min_m;
  for (const auto& [origin, tile] : tiles) {
    const Eigen::Vector2d size(tile.width_cells, tile.height_cells);
    min_m = min_m.cwiseMin(tile.origin_m);
    max_m = max_m.cwiseMax(tile.origin_m + all.resolution_m * size);
  }
  const Eigen::Vector2d cells = ((max_m - min_m) / all.resolution_m).array().round();
  all.origin_m = min_m;
  all.width_cells = static_cast<int>(cells.x());
  all.height_cells = static_cast<int>(cells.y());
  all.occupancy.assign(static_cast<std::size_t>(all.width_cells) * all.height_cells,
                       GridMap::kUnknown);
  for (const auto& [origin, tile] : tiles) {
    const Eigen::Vector2d at = ((tile.origin_m - min_m) / all.resolution_m).array().round();
    for (int y = 0; y < tile.height_cells; ++y) {
      const auto row = tile.occupancy.begin() + std::ptrdiff_t{y} * tile.width_cells;
      std::copy(row, row + tile.width_cells,
                all.occupancy.begin() +
                    (static_cast<std::ptrdiff_t>(at.y()) + y) * all.width_cells +
                    static_cast<std::ptrdiff_t>(at.x()));
    }
  }
  return all;
}

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
  scene.grid = join_tiles(view_.map_tiles);
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
