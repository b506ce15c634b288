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

// Whether a point lies on the wall's free side.
bool is_left_of(const Eigen::Vector4d& wall, const Eigen::Vector2d& point_m) {
  const Eigen::Vector2d way = wall.tail<2>() - wall.head<2>(), to = point_m - wall.head<2>();
  return way.x() * to.y() - way.y() * to.x() >= 0.0;
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

void WallFilter::correct(const std::vector<ObservedWall>& observed,
                         const std::vector<WallMatch>& matches,
                         const std::vector<ObservedCircle>& circles,
                         const std::vector<int>& circle_matches) {
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

bool WallFilter::may_see(const Eigen::Vector2d& robot_m, const Eigen::Vector4d& wall) const {
  return distance_to(robot_m, wall) <= options().judged_within_m && is_left_of(wall, robot_m);
}

int WallFilter::judge(const ScanInRobot& scan) {
  if (scan.bearing_step_rad <= 0.0) return 0;
  const Eigen::Vector2d robot_m = state().mean(0).head<2>();
  int removed = 0;
  const Eigen::Matrix3d p = robot_covariance();
  const double pose_margin_m = 2.0 * std::sqrt(std::max(p(0, 0), p(1, 1)));
  for (std::size_t i = num_walls(); i-- > 0;) {
    MapWall& wall = map_.wall(i);
    const Eigen::Vector4d mean = state().mean(wall.block);
    if (!may_see(robot_m, mean)) continue;
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
    if (circles_.holds(state(), map_.mean(i))) map_.remove(i);
  }
}

void WallFilter::judge_again(const std::vector<ScanInRobot>& scans,
                             const std::vector<Pose2>& world_from_robots) {
  for (std::size_t i = 0; i < num_walls(); ++i) map_.wall(i).evidence.forget(options().evidence);
  circles_.forget_evidence();
  std::vector<WallSeen> seen;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const Eigen::Vector2d robot_m = world_from_robots[k].translation_m();
    seen.clear();
    for (std::size_t i = 0; i < num_walls(); ++i) {
      MapWall& wall = map_.wall(i);
      const Eigen::Vector4d mean = state().mean(wall.block);
      if (!may_see(robot_m, mean)) continue;
      seen.push_back({seen_from_robot(world_from_robots[k].vector(), mean), &wall.evidence});
    }
    vote_for_nearest(scans[k], seen);
    for (const WallSeen& wall : seen) wall.evidence->count_votes(options().evidence);
    circles_.vote(state(), scans[k], world_from_robots[k]);
  }
}

WallFilter::Stored WallFilter::store() const {
  const std::vector<int> all = blocks();
  Stored stored;
  stored.covariance = state().dense_covariance(all);
  stored.mean = state().dense_mean(all);
  stored.first_estimate.resize(stored.mean.size());
  stored.first_estimate.head<3>() = state().first_estimate(0).head<3>();
  for (std::size_t k = 0; k < all.size(); ++k) {
    stored.first_estimate.segment<4>(3 + 4 * static_cast<Eigen::Index>(k)) =
        state().first_estimate(all[k]);
  }
  stored.walls = map_.walls();
  stored.circles = circles_.store();
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
  map_.restore(stored.walls, stored.next_id);
  circles_.restore(state(), stored.circles);
  state().restore(blocks(), stored.mean, stored.first_estimate, stored.covariance);
}

}  // namespace marco::slam
