#include "slam/line_slam/ekf/wall_filter.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "slam/line_slam/ekf/joint_compatibility.hpp"

namespace marco::slam {
namespace {

Eigen::Matrix3d start_covariance(const WallFilterOptions& options) {
  const double m2 = options.start_sigma_m * options.start_sigma_m;
  const double rad2 = options.start_sigma_rad * options.start_sigma_rad;
  return Eigen::Vector3d(m2, m2, rad2).asDiagonal();  // (5.40)
}

double distance_to(const Eigen::Vector2d& point_m, const Eigen::Vector4d& wall) {
  const Eigen::Vector2d way = wall.tail<2>() - wall.head<2>();
  const double part = std::clamp(
      (point_m - wall.head<2>()).dot(way) / std::max(1e-12, way.squaredNorm()), 0.0, 1.0);
  return (point_m - wall.head<2>() - part * way).norm();
}

// How far a point lies on the free side of the wall's line; from behind a wall is never seen.
double left_of(const Eigen::Vector4d& wall, const Eigen::Vector2d& point_m) {
  const Eigen::Vector2d way = wall.tail<2>() - wall.head<2>(), to = point_m - wall.head<2>();
  return (way.x() * to.y() - way.y() * to.x()) / std::max(1e-9, way.norm());
}

}  // namespace

WallFilter::WallFilter(const WallFilterOptions& options, const Pose2& world_from_robot)
    : options_(options), state_(world_from_robot.vector(), start_covariance(options)) {
  validate(options, "wall_filter");
  require(options.association == "joint" || options.association == "similar",
          "wall_filter.association must be \"joint\" or \"similar\", not \"" + options.association +
              "\"");
}

Pose2 WallFilter::world_from_robot() const {
  const Eigen::Vector4d robot = state_.mean(0);
  return {robot.x(), robot.y(), normalize_angle(robot.z())};
}

Eigen::Matrix3d WallFilter::robot_covariance() const {
  return state_.covariance(0, 0).topLeftCorner<3, 3>();
}

Segment WallFilter::segment(std::size_t index) const {
  const Eigen::Vector4d mean = wall_mean(index);
  return {mean.head<2>(), mean.tail<2>()};
}

std::vector<int> WallFilter::blocks() const {
  std::vector<int> all;
  all.reserve(walls_.size());
  for (const MapWall& wall : walls_) all.push_back(wall.block);
  return all;
}

void WallFilter::predict(const Pose2& robot_motion) {
  predict(robot_motion, motion_noise(options_.motion, world_from_robot().theta_rad, robot_motion));
}

void WallFilter::predict(const Pose2& robot_motion, const Eigen::Matrix3d& noise) {
  const Pose2 after = moved(world_from_robot(), robot_motion);
  const Eigen::Vector2d from_m = state_.first_estimate(0).head<2>();
  state_.predict(after.vector(), motion_jacobian(from_m, after.translation_m()), noise);
}

std::vector<int> WallFilter::blocks_within(double radius_m, double behind_m) const {
  const Eigen::Vector2d robot_m = state_.mean(0).head<2>();
  std::vector<int> near;
  for (const MapWall& wall : walls_) {
    const Eigen::Vector4d mean = state_.rough_mean(wall.block);
    if (distance_to(robot_m, mean) > radius_m) continue;
    if (left_of(mean, robot_m) > -behind_m) near.push_back(wall.block);
  }
  return near;
}

void WallFilter::focus() {
  state_.catch_up(std::max(options_.catch_up_tiles,
                           static_cast<int>(options_.catch_up_part * state_.num_tiles())));
  const bool all = static_cast<int>(walls_.size()) <= options_.max_dense_walls;
  if (all && state_.num_passive() == 0) return;
  const std::vector<int> needed =
      all ? blocks() : blocks_within(options_.active_radius_m, options_.active_behind_m);
  const bool missing = std::any_of(needed.begin(), needed.end(),
                                   [this](int block) { return !state_.is_active(block); });
  // A corrected pose has moved the walls that wait, too, and they are looked for where they were.
  const bool moved =
      state_.num_passive() > 0 && moved_since_focus_m_ > 0.5 * options_.active_margin_m;
  const auto wanted = [&] {
    return blocks_within(options_.active_radius_m + options_.active_margin_m,
                         options_.active_behind_m + options_.active_margin_m);
  };
  const std::size_t active = state_.active().size() - 1;
  const auto slack = static_cast<std::size_t>(options_.max_dense_walls);
  const bool too_many =
      !all && active > 2 * needed.size() + slack && active > 3 * wanted().size() / 2 + slack;
  if (!missing && !moved && !too_many) return;
  state_.refresh_means();
  std::vector<int> next = all ? needed : wanted();
  if (mark_ > 0) next.push_back(mark_);
  state_.activate(next);
  moved_since_focus_m_ = 0.0;
}

WallContext WallFilter::context(std::size_t index) const {
  const int block = walls_[index].block;
  return {state_.mean(0).head<3>(), state_.first_estimate(0).head<3>(), state_.mean(block),
          state_.first_estimate(block), block};
}

SparseRows WallFilter::rows_for(const ObservedWall& observed,
                                std::size_t index,
                                MatchedEnds ends) const {
  ObservedWall rough = observed;
  rough.across_sigma_m = std::hypot(observed.across_sigma_m, options_.across_floor_m);
  rough.direction_sigma_rad =
      std::hypot(observed.direction_sigma_rad, options_.direction_floor_rad);
  return wall_rows(rough, context(index), ends);
}

double WallFilter::end_limit_m(const ObservedWall& observed, std::size_t index) const {
  const SparseRows rows = rows_for(observed, index, {true, true});
  const SparseRows::Square s = state_.innovation_covariance(rows);
  const double sigma_m = std::sqrt(std::min(s(2, 2), s(3, 3)));
  return std::clamp(2.5 * sigma_m, options_.end_distance_m,
                    std::max(options_.end_distance_m, options_.max_end_distance_m));
}

// 5.2.5: the same end, if both are seen as ends and lie near each other.
MatchedEnds WallFilter::matched_ends(const ObservedWall& observed, std::size_t index) const {
  const MapWall& wall = walls_[index];
  MatchedEnds ends{wall.start_seen && observed.start_seen, wall.end_seen && observed.end_seen};
  if (!ends.start && !ends.end) return ends;
  const double limit_m = end_limit_m(observed, index);
  const Eigen::Vector4d seen = seen_from_robot(state_.mean(0).head<3>(), wall_mean(index));
  const Eigen::Vector2d along = observed.along();
  ends.start = ends.start && std::abs(along.dot(seen.head<2>() - observed.start_m)) <= limit_m;
  ends.end = ends.end && std::abs(along.dot(seen.tail<2>() - observed.end_m)) <= limit_m;
  return ends;
}

void WallFilter::correct(const std::vector<ObservedWall>& observed,
                         const std::vector<WallMatch>& matches) {
  const Eigen::Vector2d before_m = state_.mean(0).head<2>();
  std::vector<MatchedEnds> ends(observed.size());
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall >= 0) {
      ends[i] = matched_ends(observed[i], static_cast<std::size_t>(matches[i].wall));
    }
  }
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    const auto index = static_cast<std::size_t>(matches[i].wall);
    state_.correct(rows_for(observed[i], index, ends[i]));
    ++walls_[index].times_seen;
  }
  state_.finish_corrections();
  moved_since_focus_m_ += (state_.mean(0).head<2>() - before_m).norm();
}

std::size_t WallFilter::add(const ObservedWall& observed) {
  const Pose2 pose = world_from_robot();
  Eigen::Vector4d mean;
  mean << pose * observed.start_m, pose * observed.end_m;
  // First-estimates form of -H_xl^-1 H_xr: the lever arm starts where the robot was linearized.
  const Eigen::Vector2d from_m = state_.first_estimate(0).head<2>();
  Eigen::Matrix<double, 4, 3> by_robot;
  by_robot << 1, 0, -(mean(1) - from_m.y()), 0, 1, mean(0) - from_m.x(),  //
      1, 0, -(mean(3) - from_m.y()), 0, 1, mean(2) - from_m.x();
  ObservedWall rough = observed;
  rough.across_sigma_m = std::hypot(observed.across_sigma_m, options_.across_floor_m);
  rough.direction_sigma_rad =
      std::hypot(observed.direction_sigma_rad, options_.direction_floor_rad);
  Eigen::Matrix4d rotation = Eigen::Matrix4d::Zero();  // H_xl^-1
  rotation.topLeftCorner<2, 2>() = pose.rotation();
  rotation.bottomRightCorner<2, 2>() = pose.rotation();
  const Eigen::Matrix4d noise = rotation * rough.covariance() * rotation.transpose();

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

int WallFilter::add_new(const std::vector<ObservedWall>& observed,
                        std::vector<WallMatch>& matches) {
  int added = 0;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall != WallMatch::kNew || observed[i].num_points < options_.new_wall_points ||
        observed[i].length_m() < options_.new_wall_length_m) {
      continue;
    }
    matches[i].wall = static_cast<int>(add(observed[i]));
    ++added;
  }
  return added;
}

void WallFilter::remove(std::size_t index) {
  state_.remove(walls_[index].block);
  if (index + 1 != walls_.size()) walls_[index] = std::move(walls_.back());
  walls_.pop_back();
}

void WallFilter::mark_pose() {
  if (mark_ > 0) state_.remove(mark_);
  Eigen::Matrix<double, 4, 3> same = Eigen::Matrix<double, 4, 3>::Zero();
  same.topRows<3>().setIdentity();
  mark_ = state_.append(state_.mean(0), state_.first_estimate(0), same, Eigen::Matrix4d::Zero());
}

std::optional<WallFilter::SinceMark> WallFilter::since_mark() const {
  if (mark_ == 0) return std::nullopt;
  const Eigen::Vector4d then = state_.mean(mark_), now = state_.mean(0);
  const Pose2 world_from_mark{then.x(), then.y(), normalize_angle(then.z())};
  const Eigen::Matrix2d to_mark = world_from_mark.rotation().transpose();
  const Eigen::Vector2d way_m = to_mark * (now.head<2>() - then.head<2>());
  Eigen::Matrix<double, 3, 6> jacobian = Eigen::Matrix<double, 3, 6>::Zero();  // by mark, by robot
  jacobian.topLeftCorner<2, 2>() = -to_mark;
  jacobian.block<2, 1>(0, 2) = Eigen::Vector2d(way_m.y(), -way_m.x());
  jacobian(2, 2) = -1.0;
  jacobian.block<2, 2>(0, 3) = to_mark;
  jacobian(2, 5) = 1.0;
  Eigen::Matrix<double, 6, 6> both;
  both.topLeftCorner<3, 3>() = state_.covariance(mark_, mark_).topLeftCorner<3, 3>();
  both.topRightCorner<3, 3>() = state_.covariance(mark_, 0).topLeftCorner<3, 3>();
  both.bottomLeftCorner<3, 3>() = both.topRightCorner<3, 3>().transpose();
  both.bottomRightCorner<3, 3>() = robot_covariance();
  return SinceMark{between(world_from_mark, world_from_robot()),
                   jacobian * both * jacobian.transpose()};
}

}  // namespace marco::slam
