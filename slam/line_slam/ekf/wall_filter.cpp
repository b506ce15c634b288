#include "slam/line_slam/ekf/wall_filter.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "slam/line_slam/ekf/ray_votes.hpp"
#include "slam/line_slam/ekf/wall_growth.hpp"

namespace marco::slam {
namespace {

double distance_to(const Eigen::Vector2d& point_m, const Eigen::Vector4d& wall) {
  const Eigen::Vector2d way = wall.tail<2>() - wall.head<2>();
  const double part = std::clamp(
      (point_m - wall.head<2>()).dot(way) / std::max(1e-12, way.squaredNorm()), 0.0, 1.0);
  return (point_m - wall.head<2>() - part * way).norm();
}

// How far a point lies on the free side of the wall's line; a wall is never seen from behind.
double left_of(const Eigen::Vector4d& wall, const Eigen::Vector2d& point_m) {
  const Eigen::Vector2d way = wall.tail<2>() - wall.head<2>(), to = point_m - wall.head<2>();
  return (way.x() * to.y() - way.y() * to.x()) / std::max(1e-9, way.norm());
}

}  // namespace

void WallFilter::predict(const Pose2& robot_motion) {
  predict(robot_motion, motion_noise(options().motion, world_from_robot().theta_rad, robot_motion));
}

void WallFilter::predict(const Pose2& robot_motion, const Eigen::Matrix3d& noise) {
  const Pose2 after = moved(world_from_robot(), robot_motion);
  const Eigen::Vector2d from_m = state().first_estimate(0).head<2>();
  state().predict(after.vector(), motion_jacobian(from_m, after.translation_m()), noise);
}

void WallFilter::place(const Pose2& world_from_robot, const Eigen::Matrix3d& covariance) {
  state().predict(world_from_robot.vector(), Eigen::Matrix3d::Zero(), covariance);
}

std::vector<int> WallFilter::blocks() const {
  std::vector<int> all = map_.blocks();
  const std::vector<int> round = circles_.blocks();
  all.insert(all.end(), round.begin(), round.end());
  return all;
}

std::vector<int> WallFilter::blocks_within(double radius_m, double behind_m) const {
  const Eigen::Vector2d robot_m = state().mean(0).head<2>();
  std::vector<int> near = circles_.blocks_within(state(), robot_m, radius_m);
  for (const MapWall& wall : map_.walls()) {
    const Eigen::Vector4d mean = state().rough_mean(wall.block);
    if (distance_to(robot_m, mean) > radius_m) continue;
    if (left_of(mean, robot_m) > -behind_m) near.push_back(wall.block);
  }
  return near;
}

void WallFilter::focus() {
  state().catch_up(std::max(options().catch_up_tiles,
                            static_cast<int>(options().catch_up_part * state().num_tiles())));
  const bool all = static_cast<int>(num_walls() + circles_.size()) <= options().max_dense_walls;
  if (all && state().num_passive() == 0) return;
  const std::vector<int> needed =
      all ? blocks() : blocks_within(options().active_radius_m, options().active_behind_m);
  const bool missing = std::any_of(needed.begin(), needed.end(),
                                   [this](int block) { return !state().is_active(block); });
  // A corrected pose moves passive walls too, but they are searched at their old places.
  const bool moved =
      state().num_passive() > 0 && moved_since_focus_m_ > 0.5 * options().active_margin_m;
  const auto wanted = [&] {
    return blocks_within(options().active_radius_m + options().active_margin_m,
                         options().active_behind_m + options().active_margin_m);
  };
  const std::size_t active = state().active().size() - 1;
  const auto slack = static_cast<std::size_t>(options().max_dense_walls);
  const bool too_many =
      !all && active > 2 * needed.size() + slack && active > 3 * wanted().size() / 2 + slack;
  if (!missing && !moved && !too_many) return;
  state().refresh_means();
  std::vector<int> next = all ? needed : wanted();
  state().activate(next);
  moved_since_focus_m_ = 0.0;
}

void WallFilter::correct(const std::vector<ObservedWall>& observed,
                         const std::vector<WallMatch>& matches,
                         const std::vector<ObservedCircle>& circles,
                         const std::vector<int>& circle_matches) {
  const Eigen::Vector2d before_m = state().mean(0).head<2>();
  std::vector<MatchedEnds> ends(observed.size());
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall >= 0) {
      ends[i] = map_.matched_ends(observed[i], static_cast<std::size_t>(matches[i].wall));
    }
  }
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    const auto index = static_cast<std::size_t>(matches[i].wall);
    state().correct(map_.measurement(observed[i], index, ends[i]));
    ++map_.wall(index).times_seen;
  }
  circles_.correct(state(), circles, circle_matches);
  state().finish_corrections();
  moved_since_focus_m_ += (state().mean(0).head<2>() - before_m).norm();
}

void WallFilter::extend(const std::vector<ObservedWall>& observed,
                        const std::vector<WallMatch>& matches) {
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    extend_wall(map_, static_cast<std::size_t>(matches[i].wall), observed[i]);
  }
}

int WallFilter::add_new(const std::vector<ObservedWall>& observed,
                        std::vector<WallMatch>& matches) {
  int added = 0;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall != WallMatch::kNew || observed[i].num_points < options().new_wall_points ||
        observed[i].length_m() < options().new_wall_length_m) {
      continue;
    }
    matches[i].wall = static_cast<int>(add(observed[i]));
    ++added;
  }
  return added;
}

void WallFilter::join(std::size_t a, std::size_t b) { join_walls(map_, a, b); }

int WallFilter::join_similar(const std::vector<WallMatch>& matches) {
  return join_similar_walls(map_, matches);
}

int WallFilter::judge(const ScanInRobot& scan) {
  if (scan.bearing_step_rad <= 0.0) return 0;
  const Eigen::Vector2d robot_m = state().mean(0).head<2>();
  int removed = 0;
  const Eigen::Matrix3d p = robot_covariance();
  const double pose_margin_m = 2.0 * std::sqrt(std::max(p(0, 0), p(1, 1)));
  for (std::size_t i = num_walls(); i-- > 0;) {
    MapWall& wall = map_.wall(i);
    if (!state().is_active(wall.block)) continue;
    const Eigen::Vector4d mean = state().mean(wall.block);
    const double far_m = options().active_radius_m + (mean.tail<2>() - mean.head<2>()).norm();
    if ((mean.head<2>() - robot_m).norm() > far_m) continue;
    vote_by_rays(scan, seen_from_robot(state().mean(0).head<3>(), mean), pose_margin_m,
                 wall.evidence);
    wall.evidence.count_votes(options().evidence);
    if (wall.evidence.existence() >= options().evidence.forget_probability) continue;
    map_.remove(i);
    ++removed;
  }
  return removed;
}

void WallFilter::draw_circles(const std::vector<ObservedCircle>& observed,
                              const std::vector<int>& matches,
                              const ScanInRobot& scan) {
  circles_.extend(state(), observed, matches);
  circles_.add_new(state(), observed, matches);
  circles_.join_concentric(state());
  const Eigen::Matrix3d p = robot_covariance();
  circles_.judge(state(), scan, 2.0 * std::sqrt(std::max(p(0, 0), p(1, 1))));
  for (std::size_t i = num_walls(); i-- > 0 && circles_.size() > 0;) {
    const int block = map_.wall(i).block;
    if (state().is_active(block) && circles_.holds(state(), state().mean(block))) map_.remove(i);
  }
}

void WallFilter::judge_again(const std::vector<ScanInRobot>& scans,
                             const std::vector<Pose2>& world_from_robots) {
  state().refresh_means();
  for (std::size_t i = 0; i < num_walls(); ++i) map_.wall(i).evidence.forget(options().evidence);
  circles_.forget_evidence();
  std::vector<WallSeen> seen;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const Eigen::Vector2d robot_m = world_from_robots[k].translation_m();
    seen.clear();
    for (std::size_t i = 0; i < num_walls(); ++i) {
      MapWall& wall = map_.wall(i);
      const Eigen::Vector4d mean = state().rough_mean(wall.block);
      if (distance_to(robot_m, mean) > options().active_radius_m || left_of(mean, robot_m) < 0.0) {
        continue;
      }
      seen.push_back({seen_from_robot(world_from_robots[k].vector(), mean), &wall.evidence});
    }
    vote_for_nearest(scans[k], seen);
    for (const WallSeen& wall : seen) wall.evidence->count_votes(options().evidence);
    circles_.vote(state(), scans[k], world_from_robots[k]);
  }
}

WallFilter::Stored WallFilter::store() {
  const std::vector<int> all = blocks();
  Stored stored;
  for (const int block : state().active().subspan(1)) {
    const auto at = std::find(all.begin(), all.end(), block);
    stored.active.push_back(static_cast<int32_t>(at - all.begin()));
  }
  stored.covariance = state().dense_covariance(all);
  state().catch_up(state().num_tiles());
  stored.mean = state().dense_mean(all);
  stored.first_estimate.resize(stored.mean.size());
  stored.first_estimate.head<3>() = state().first_estimate(0).head<3>();
  for (std::size_t k = 0; k < all.size(); ++k) {
    stored.first_estimate.segment<4>(3 + 4 * static_cast<Eigen::Index>(k)) =
        state().first_estimate(all[k]);
  }
  stored.walls = map_.walls();
  stored.circles = circles_.store();
  stored.moved_since_focus_m = moved_since_focus_m_;
  stored.next_id = map_.next_id();
  return stored;
}

void WallFilter::restore(const Stored& stored) {
  const std::size_t count = stored.walls.size() + stored.circles.circles.size();
  const auto size = static_cast<Eigen::Index>(3 + 4 * count);
  require(stored.mean.size() == size && stored.first_estimate.size() == size &&
              stored.covariance.rows() == size && stored.covariance.cols() == size,
          "wall_filter: stored sizes do not agree");
  require(
      stored.mean.allFinite() && stored.first_estimate.allFinite() && stored.covariance.allFinite(),
      "wall_filter: stored values are not finite");
  std::vector<char> is_active(count, 0);
  for (const int32_t index : stored.active) {
    const bool known = index >= 0 && static_cast<std::size_t>(index) < count;
    require(known && is_active[static_cast<std::size_t>(index)] == 0,
            "wall_filter: stored active part names a missing wall, or one twice");
    is_active[static_cast<std::size_t>(index)] = 1;
  }
  map_.restore(stored.walls, stored.next_id);
  circles_.restore(state(), stored.circles);
  const std::vector<int> all = blocks();
  state().restore(all, stored.mean, stored.first_estimate, stored.covariance);
  std::vector<int> active;
  for (const int32_t index : stored.active) active.push_back(all[static_cast<std::size_t>(index)]);
  state().activate(active);
  moved_since_focus_m_ = stored.moved_since_focus_m;
}

}  // namespace marco::slam
