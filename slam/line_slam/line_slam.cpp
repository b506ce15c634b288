#include "slam/line_slam/line_slam.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

// Part of the walls' points that lie on matched walls.
double overlap_of(const std::vector<ObservedWall>& observed,
                  const std::vector<WallMatch>& matches) {
  int all = 0, matched = 0;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    all += observed[i].num_points;
    if (matches[i].wall >= 0) matched += observed[i].num_points;
  }
  return all == 0 ? 0.0 : static_cast<double>(matched) / all;
}

// Walls but those whose beams lie on a curved wall.
std::vector<ObservedWall> without_chords(const std::vector<ObservedWall>& walls,
                                         const std::vector<ObservedCircle>& circles) {
  std::vector<ObservedWall> straight;
  for (const ObservedWall& wall : walls) {
    const bool chord = std::any_of(circles.begin(), circles.end(), [&](const ObservedCircle& c) {
      const int shared =
          std::min(wall.last_beam, c.last_beam) - std::max(wall.first_beam, c.first_beam);
      return c.clear && 2 * shared > wall.last_beam - wall.first_beam;
    });
    if (!chord) straight.push_back(wall);
  }
  return straight;
}

}  // namespace

LineSlam::LineSlam(const LineSlamOptions& options, const Pose2& world_from_robot)
    : options_(options), extractor_(options.lines), filter_(options.filter, world_from_robot) {
  validate(options, "line_slam");
}

LineSlamUpdate LineSlam::process(const ScanInRobot& scan,
                                 const Pose2& robot_motion,
                                 MapUse use,
                                 LineSlamJournal* journal) {
  if (!step_is_due(robot_motion)) return carry(robot_motion);
  filter_.predict(robot_motion);
  return take(scan, use, journal);
}

bool LineSlam::step_is_due(const Pose2& robot_motion) {
  if (scans_since_step_ > 0) {
    step_from_robot_ = step_from_robot_ * robot_motion;
    const bool near = step_from_robot_.translation_m().norm() < options_.step_m &&
                      std::abs(step_from_robot_.theta_rad) < deg_to_rad(options_.step_deg);
    if (near && scans_since_step_ < options_.step_scans) {
      ++scans_since_step_;
      return false;
    }
  }
  step_from_robot_ = {};
  scans_since_step_ = 1;
  return true;
}

LineSlamUpdate LineSlam::process_at(const ScanInRobot& scan,
                                    const Pose2& world_from_robot,
                                    const Eigen::Matrix3d& covariance) {
  filter_.place(world_from_robot, covariance);
  return take(scan, MapUse::draw, nullptr);
}

LineSlamUpdate LineSlam::take(const ScanInRobot& scan, MapUse use, LineSlamJournal* journal) {
  const std::vector<ObservedCircle>& circles =
      circle_extractor_.extract(scan, options_.lines.max_range_m);
  const std::vector<ObservedWall> observed = without_chords(extractor_.extract(scan), circles);
  std::vector<WallMatch> matches = filter_.associate(observed);
  const std::vector<int> circle_matches = filter_.associate(circles);
  if (journal != nullptr) note(*journal, observed, matches);

  LineSlamUpdate changes;
  const double overlap = overlap_of(observed, matches);
  for (const WallMatch& match : matches) {
    changes.matched += match.wall >= 0 ? 1 : 0;
    changes.unclear += match.wall == WallMatch::kUnclear ? 1 : 0;
  }
  filter_.correct(observed, matches, circles, circle_matches);
  if (use == MapUse::draw) {
    filter_.extend(observed, matches);
    changes.added = filter_.add_new(observed, matches);
    changes.joined = filter_.join_similar(matches);
    changes.removed = filter_.judge(scan);
    filter_.draw_circles(circles, circle_matches, scan);
  }

  LineSlamUpdate result = report();
  result.looked = true;
  result.observed = static_cast<int>(observed.size());
  result.matched = changes.matched;
  result.unclear = changes.unclear;
  result.added = changes.added;
  result.joined = changes.joined;
  result.removed = changes.removed;
  result.overlap = overlap;
  if (journal != nullptr) {
    journal->robot_corrected = result.world_from_robot.vector();
    journal->covariance_corrected = result.covariance;
  }
  return result;
}

LineSlamUpdate LineSlam::carry(const Pose2& robot_motion) {
  filter_.predict(robot_motion);
  return report();
}

void LineSlam::doubt() {
  filter_.predict({}, diagonal_covariance(options_.doubt_sigma_m, options_.doubt_sigma_rad));
}

Walls LineSlam::plan() const {
  return filter_.plan(options_.plan_min_times_seen, options_.plan_min_length_m);
}

LineMap LineSlam::map() const {
  LineMap map{plan(), filter_.round_walls(options_.plan_min_times_seen), {}};
  drop_posts_on_walls(map.walls, map.round_walls);
  map.corners = filter_.corners(map.walls);
  return map;
}

LineSlamUpdate LineSlam::report() const {
  LineSlamUpdate update;
  update.world_from_robot = filter_.world_from_robot();
  update.covariance = filter_.robot_covariance();
  update.walls = static_cast<int>(filter_.num_walls());
  return update;
}

LineSlam::Stored LineSlam::store() const {
  return {filter_.store(), step_from_robot_, scans_since_step_};
}

void LineSlam::restore(const Stored& stored) {
  filter_.restore(stored.filter);
  step_from_robot_ = stored.step_from_robot;
  scans_since_step_ = stored.scans_since_step;
}

void LineSlam::note(LineSlamJournal& journal,
                    const std::vector<ObservedWall>& observed,
                    const std::vector<WallMatch>& matches) const {
  journal.robot_predicted = filter_.world_from_robot().vector();
  journal.covariance_predicted = filter_.robot_covariance();
  journal.observed = observed;
  journal.matches = matches;
  journal.wall_ids.assign(observed.size(), 0);
  journal.innovations.assign(observed.size(), Eigen::Vector2d::Zero());
  journal.innovation_covariances.assign(observed.size(), Eigen::Matrix2d::Zero());
  journal.robot_gains.assign(observed.size(), Eigen::Matrix<double, 3, 2>::Zero());
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    const auto index = static_cast<std::size_t>(matches[i].wall);
    journal.wall_ids[i] = filter_.wall(index).id;
    const SparseRows rows = filter_.line_innovation(observed[i], index);
    journal.innovations[i] = rows.innovation;
    const Eigen::Matrix2d s = filter_.state().innovation_covariance(rows);
    journal.innovation_covariances[i] = s;
    journal.robot_gains[i] = filter_.state().covariance_with(rows).topRows<3>() * s.inverse();
  }
}

}  // namespace marco::slam
