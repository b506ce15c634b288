#include "slam/key_scan_grid.hpp"

#include <algorithm>
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
  const std::size_t known = known_as_drawn(keys);
  if (known == 0 && !drawn_.empty()) {
    grid_.clear();
    drawn_.clear();
    ++times_redrawn_;
  }
  anew_.reset();
  draw_more(keys, known, keys.size());
  return grid_;
}

bool KeyScanGrid::draw_more(const std::vector<KeyScan>& keys,
                            std::size_t known,
                            std::size_t at_most) {
  const std::size_t end = std::min(keys.size(), known + at_most);
  for (; known < end; ++known) {
    insert(keys[known], grid_);
    drawn_.push_back({keys[known].utime, keys[known].world_from_robot});
  }
  return end == keys.size();
}

bool KeyScanGrid::advance(const std::vector<KeyScan>& keys, int at_most) {
  const auto count = static_cast<std::size_t>(at_most);
  if (!anew_) {
    const std::size_t known = known_as_drawn(keys);
    if (known > 0 || drawn_.empty()) return draw_more(keys, known, count);
    anew_ = std::make_unique<KeyScanGrid>(options_);
  }
  const std::size_t known = anew_->known_as_drawn(keys);
  if (known == 0 && !anew_->drawn_.empty()) {  // they moved again
    anew_ = std::make_unique<KeyScanGrid>(options_);
  }
  if (!anew_->draw_more(keys, known, count)) return false;
  grid_ = std::move(anew_->grid_);
  drawn_ = std::move(anew_->drawn_);
  anew_.reset();
  ++times_redrawn_;
  return true;
}

std::size_t KeyScanGrid::known_as_drawn(const std::vector<KeyScan>& keys) {
  if (drawn_.empty()) return 0;
  std::size_t known = 0;
  for (const StampedPose2& drawn : drawn_) {
    // One that has become one with another leaves its light where it was.
    if (known == keys.size() || keys[known].utime != drawn.utime) continue;
    const Pose2 moved = between(drawn.world_from_robot, keys[known].world_from_robot);
    const double far_m = moved.translation_m().norm() + kFarM * std::abs(moved.theta_rad);
    if (far_m > 0.5 * options_.resolution_m) return 0;
    ++known;
  }
  const bool last_is_known = known > 0 && keys[known - 1].utime == drawn_.back().utime;
  if (!last_is_known || 2 * known < drawn_.size()) return 0;
  std::size_t kept = 0;
  for (const StampedPose2& drawn : drawn_) {
    if (kept < known && keys[kept].utime == drawn.utime) drawn_[kept++] = drawn;
  }
  drawn_.resize(kept);
  return known;
}

}  // namespace marco::slam
