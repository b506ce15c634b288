#include "slam/line_slam.hpp"

namespace marco::slam {

LineSlam::LineSlam(const LineSlamOptions& options, const Pose2& world_from_robot)
    : options_(options), extractor_(options.lines), filter_(options.filter, world_from_robot) {
  validate(options, "line_slam");
}

LineSlamUpdate LineSlam::process(const ScanInRobot& scan,
                                 const std::optional<Pose2>& robot_motion,
                                 LineSlamJournal* journal) {
  const Pose2 before = filter_.world_from_robot();
  if (robot_motion) {
    filter_.predict(*robot_motion);
  } else {
    const double m2 = options_.guess_sigma_m * options_.guess_sigma_m;
    const double rad2 = options_.guess_sigma_rad * options_.guess_sigma_rad;
    filter_.predict(last_motion_, Eigen::Vector3d(m2, m2, rad2).asDiagonal());
  }
  filter_.focus();
  const std::vector<ObservedWall>& observed = extractor_.extract(scan);
  std::vector<WallMatch> matches = filter_.associate(observed);
  if (journal != nullptr) note(*journal, observed, matches);

  LineSlamUpdate update;
  int points = 0, matched_points = 0;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    points += observed[i].num_points;
    if (matches[i].wall >= 0) matched_points += observed[i].num_points;
    update.matched += matches[i].wall >= 0 ? 1 : 0;
    update.unclear += matches[i].wall == WallMatch::kUnclear ? 1 : 0;
  }
  filter_.correct(observed, matches);
  filter_.extend(observed, matches);
  update.added = filter_.add_new(observed, matches);
  update.joined = filter_.join_similar(matches);
  update.removed = filter_.judge(scan);
  last_motion_ = between(before, filter_.world_from_robot());

  LineSlamUpdate result = report();
  result.observed = static_cast<int>(observed.size());
  result.matched = update.matched;
  result.unclear = update.unclear;
  result.added = update.added;
  result.joined = update.joined;
  result.removed = update.removed;
  result.overlap = points == 0 ? 0.0 : static_cast<double>(matched_points) / points;
  if (journal != nullptr) {
    journal->robot_corrected = result.world_from_robot.vector();
    journal->covariance_corrected = result.covariance;
  }
  return result;
}

LineSlamUpdate LineSlam::carry(const Pose2& robot_motion) {
  filter_.predict(robot_motion);
  last_motion_ = robot_motion;
  return report();
}

Walls LineSlam::plan() {
  return filter_.plan(options_.plan_min_times_seen, options_.plan_min_length_m);
}

LineSlamUpdate LineSlam::report() const {
  LineSlamUpdate update;
  update.world_from_robot = filter_.world_from_robot();
  update.covariance = filter_.robot_covariance();
  update.walls = static_cast<int>(filter_.num_walls());
  update.active_walls = static_cast<int>(filter_.state().active().size()) - 1;
  return update;
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
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    const auto index = static_cast<std::size_t>(matches[i].wall);
    journal.wall_ids[i] = filter_.wall(index).id;
    const SparseRows rows = filter_.line_innovation(observed[i], index);
    journal.innovations[i] = rows.innovation;
    journal.innovation_covariances[i] = filter_.state().innovation_covariance(rows);
  }
}

}  // namespace marco::slam
