#include "slam/key_scan_grid.hpp"

#include <cmath>

namespace marco::slam {
namespace {

constexpr double kFarM = 10.0;

void insert(const KeyScan& key, OccupancyGrid& grid) {
  grid.insert(key.world_from_robot * key.points_in_robot.points,
              key.world_from_robot * key.sensor_in_robot);
}

}  // namespace

OccupancyGrid draw_grid(const std::vector<KeyScan>& keys, const OccupancyGridOptions& options) {
  OccupancyGrid grid(options);
  for (const KeyScan& key : keys) insert(key, grid);
  return grid;
}

KeyScanGrid::KeyScanGrid(const OccupancyGridOptions& options) : options_(options), grid_(options) {}

const OccupancyGrid& KeyScanGrid::update(const std::vector<KeyScan>& keys) {
  if (!is_as_drawn(keys)) {
    grid_.clear();
    drawn_.clear();
    ++times_redrawn_;
  }
  for (std::size_t i = drawn_.size(); i < keys.size(); ++i) {
    insert(keys[i], grid_);
    drawn_.push_back({keys[i].utime, keys[i].world_from_robot});
  }
  return grid_;
}

bool KeyScanGrid::is_as_drawn(const std::vector<KeyScan>& keys) const {
  if (keys.size() < drawn_.size()) return false;
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    if (keys[i].utime != drawn_[i].utime) return false;
    const Pose2 moved = between(drawn_[i].world_from_robot, keys[i].world_from_robot);
    const double far_m = moved.translation_m().norm() + kFarM * std::abs(moved.theta_rad);
    if (far_m > 0.5 * options_.resolution_m) return false;
  }
  return true;
}

}  // namespace marco::slam
