#include "slam/map/keyframe_grid.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace marco::slam {
namespace {

constexpr double kFarM = 10.0;  // of a keyframe's points, which a turn moves by so much
constexpr int kDrawing = 16;    // costs so much as looking whether there is something to draw

void insert(const Keyframe& key, OccupancyGrid& grid) {
  grid.insert(key.world_from_robot * key.points_in_robot.points,
              key.world_from_robot * key.sensor_in_robot);
}

}  // namespace

OccupancyGrid draw_grid(const std::vector<Keyframe>& keys, const OccupancyGridOptions& options) {
  OccupancyGrid grid(options);
  for (const Keyframe& key : keys) insert(key, grid);
  return grid;
}

KeyframeGrid::KeyframeGrid(const OccupancyGridOptions& options)
    : options_(options), grid_(options) {}

const OccupancyGrid& KeyframeGrid::update(const std::vector<Keyframe>& keys) {
  while (!advance(keys, std::numeric_limits<int>::max() / kDrawing)) {
  }
  return grid_;
}

bool KeyframeGrid::advance(const std::vector<Keyframe>& keys, int at_most) {
  int budget = kDrawing * at_most;
  if (!redraw_ || !same(compare(redraw_->keys, keys))) {
    Change change = compare(drawn_, keys);
    if (change.all || change.some) {
      begin_redraw(keys, std::move(change));
    } else {
      drawn_ = std::move(change.remaining);
      left_.insert(left_.end(), change.left.begin(), change.left.end());
      redraw_.reset();
    }
  }
  if (redraw_ && !advance_redraw(keys, budget)) return false;
  while (drawn_.size() < keys.size() && budget >= kDrawing) {
    const Keyframe& key = keys[drawn_.size()];
    insert(key, grid_);
    drawn_.push_back(place(key));
    ++drawn_count_;
    budget -= kDrawing;
  }
  return drawn_.size() == keys.size();
}

bool KeyframeGrid::same(const Change& change) {
  return !change.all && !change.some && change.left.empty();
}

KeyframeGrid::Drawn KeyframeGrid::place(const Keyframe& key) const {
  return {key.utime, key.world_from_robot,
          grid_.box_of(key.world_from_robot * key.points_in_robot.points,
                       key.world_from_robot * key.sensor_in_robot)};
}

KeyframeGrid::Change KeyframeGrid::compare(const std::vector<Drawn>& drawn,
                                           const std::vector<Keyframe>& keys) const {
  Change change;
  change.remaining.reserve(drawn.size());
  bool last_is_there = drawn.empty();
  for (const Drawn& before : drawn) {
    const std::size_t known = change.remaining.size();
    last_is_there = known < keys.size() && keys[known].utime == before.utime;
    if (!last_is_there) {
      change.left.push_back(before.box);
      continue;
    }
    const Pose2 moved = between(before.world_from_robot, keys[known].world_from_robot);
    const double far_m = moved.translation_m().norm() + kFarM * std::abs(moved.theta_rad);
    const bool stays = far_m <= 0.5 * options_.resolution_m;
    change.remaining.push_back(stays ? before : place(keys[known]));
    if (stays) continue;
    change.some = true;
    change.touched.push_back(before.box);
    change.touched.push_back(change.remaining.back().box);
  }
  change.all = !last_is_there || 2 * change.remaining.size() < drawn.size();
  return change;
}

void KeyframeGrid::begin_redraw(const std::vector<Keyframe>& keys, Change change) {
  redraw_.emplace(Redraw{OccupancyGrid(options_), {}, std::move(change.remaining), 0});
  if (change.all) {
    redraw_->keys.clear();
    for (const Keyframe& key : keys) redraw_->keys.push_back(place(key));
    return;
  }
  redraw_->grid.be_part_of(grid_);
  for (const auto* boxes : {&change.touched, &change.left, &left_}) {
    for (const OccupancyGrid::TileBox& box : *boxes) OccupancyGrid::add(box, redraw_->tiles);
  }
}

bool KeyframeGrid::advance_redraw(const std::vector<Keyframe>& keys, int& budget) {
  for (; redraw_->next < redraw_->keys.size(); ++redraw_->next) {
    if (budget < kDrawing) return false;
    const Drawn& drawn = redraw_->keys[redraw_->next];
    --budget;
    if (!redraw_->tiles.empty() && !OccupancyGrid::touches(drawn.box, redraw_->tiles)) continue;
    const Keyframe& key = keys[redraw_->next];
    const Points2 hits = drawn.world_from_robot * key.points_in_robot.points;
    const Eigen::Vector2d sensor = drawn.world_from_robot * key.sensor_in_robot;
    if (redraw_->tiles.empty()) {
      redraw_->grid.insert(hits, sensor);
    } else {
      redraw_->grid.insert_in(redraw_->tiles, hits, sensor);
    }
    ++drawn_count_;
    budget -= kDrawing - 1;
  }
  if (redraw_->tiles.empty()) {
    grid_ = std::move(redraw_->grid);
  } else {
    grid_.replace(redraw_->tiles, std::move(redraw_->grid));
  }
  drawn_ = std::move(redraw_->keys);
  left_.clear();
  redraw_.reset();
  ++times_redrawn_;
  return true;
}

}  // namespace marco::slam
