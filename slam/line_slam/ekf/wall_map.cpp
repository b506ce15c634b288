#include "slam/line_slam/ekf/wall_map.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

Eigen::Matrix3d start_covariance(const WallFilterOptions& options) {
  const double m2 = options.start_sigma_m * options.start_sigma_m;
  const double rad2 = options.start_sigma_rad * options.start_sigma_rad;
  return Eigen::Vector3d(m2, m2, rad2).asDiagonal();  // (5.40)
}

}  // namespace

WallMap::WallMap(const WallFilterOptions& options, const Pose2& world_from_robot)
    : options_(options), state_(world_from_robot.vector(), start_covariance(options)) {
  validate(options, "wall_filter");
  require(options.association == "joint" || options.association == "similar",
          "wall_filter.association must be \"joint\" or \"similar\", not \"" + options.association +
              "\"");
}

Pose2 WallMap::world_from_robot() const {
  const Eigen::Vector4d robot = state_.mean(0);
  return {robot.x(), robot.y(), normalize_angle(robot.z())};
}

Eigen::Matrix3d WallMap::robot_covariance() const {
  return state_.covariance(0, 0).topLeftCorner<3, 3>();
}

Segment WallMap::segment(std::size_t index) const {
  const Eigen::Vector4d ends = mean(index);
  return {ends.head<2>(), ends.tail<2>()};
}

Segment WallMap::seen_in_world(const ObservedWall& observed) const {
  const Pose2 pose = world_from_robot();
  return {pose * observed.start_m, pose * observed.end_m};
}

std::vector<int> WallMap::blocks() const {
  std::vector<int> all;
  all.reserve(walls_.size());
  for (const MapWall& wall : walls_) all.push_back(wall.block);
  return all;
}

ObservedWall WallMap::with_floors(const ObservedWall& observed) const {
  ObservedWall rough = observed;
  rough.across_sigma_m = std::hypot(observed.across_sigma_m, options_.across_floor_m);
  rough.direction_sigma_rad =
      std::hypot(observed.direction_sigma_rad, options_.direction_floor_rad);
  return rough;
}

SparseRows WallMap::measurement(const ObservedWall& observed,
                                std::size_t index,
                                MatchedEnds ends) const {
  const int block = walls_[index].block;
  const WallContext context{state_.mean(0).head<3>(), state_.first_estimate(0).head<3>(),
                            state_.mean(block), state_.first_estimate(block), block};
  return wall_rows(with_floors(observed), context, ends);
}

double WallMap::end_limit_m(const ObservedWall& observed, std::size_t index) const {
  const SparseRows rows = measurement(observed, index, {true, true});
  const SparseRows::Square s = state_.innovation_covariance(rows);
  const double sigma_m = std::sqrt(std::min(s(2, 2), s(3, 3)));
  return std::clamp(2.5 * sigma_m, options_.end_distance_m,
                    std::max(options_.end_distance_m, options_.max_end_distance_m));
}

MatchedEnds WallMap::matched_ends(const ObservedWall& observed, std::size_t index) const {
  const MapWall& wall = walls_[index];
  MatchedEnds ends{wall.start_seen && observed.start_seen, wall.end_seen && observed.end_seen};
  if (!ends.start && !ends.end) return ends;
  const double limit_m = end_limit_m(observed, index);
  const Eigen::Vector4d seen = seen_from_robot(state_.mean(0).head<3>(), mean(index));
  const Eigen::Vector2d along = observed.along();
  ends.start = ends.start && std::abs(along.dot(seen.head<2>() - observed.start_m)) <= limit_m;
  ends.end = ends.end && std::abs(along.dot(seen.tail<2>() - observed.end_m)) <= limit_m;
  return ends;
}

std::size_t WallMap::add(const ObservedWall& observed) {
  const Pose2 pose = world_from_robot();
  Eigen::Vector4d mean;
  mean << pose * observed.start_m, pose * observed.end_m;
  // First-estimates form of -H_xl^-1 H_xr: the lever arm starts where the robot was linearized.
  const Eigen::Vector2d from_m = state_.first_estimate(0).head<2>();
  Eigen::Matrix<double, 4, 3> by_robot;
  by_robot << 1, 0, -(mean(1) - from_m.y()), 0, 1, mean(0) - from_m.x(),  //
      1, 0, -(mean(3) - from_m.y()), 0, 1, mean(2) - from_m.x();
  Eigen::Matrix4d rotation = Eigen::Matrix4d::Zero();  // H_xl^-1
  rotation.topLeftCorner<2, 2>() = pose.rotation();
  rotation.bottomRightCorner<2, 2>() = pose.rotation();
  const Eigen::Matrix4d noise =
      rotation * with_floors(observed).covariance() * rotation.transpose();

  MapWall wall;
  wall.id = next_id_++;
  wall.block = state_.append(mean, mean, by_robot, noise);
  wall.times_seen = 1;
  wall.start_seen = observed.start_seen;
  wall.end_seen = observed.end_seen;
  wall.evidence = WallEvidence(options_.evidence, observed.length_m());
  walls_.push_back(std::move(wall));
  return walls_.size() - 1;
}

void WallMap::remove(std::size_t index) {
  state_.remove(walls_[index].block);
  if (index + 1 != walls_.size()) walls_[index] = std::move(walls_.back());
  walls_.pop_back();
}

void WallMap::restore(const std::vector<MapWall>& walls, int64_t next_id) {
  state_ = EkfState(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero());
  walls_ = walls;
  next_id_ = next_id;
  for (MapWall& wall : walls_) {
    wall.block = state_.append(Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero(),
                               Eigen::Matrix<double, 4, 3>::Zero(), Eigen::Matrix4d::Zero());
  }
}

}  // namespace marco::slam
