#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "slam/line_slam/ekf/joint_compatibility.hpp"
#include "slam/line_slam/ekf/wall_filter.hpp"

namespace marco::slam {
namespace {

// Whether two walls of one scan lie surely apart across; the pose has no part in that.
bool are_two(const ObservedWall& a, const ObservedWall& b) {
  constexpr double kLeastStepM = 0.025;
  constexpr double kSureSigmas = 4.0;
  const bool a_first = a.num_points >= b.num_points;
  const ObservedWall& base = a_first ? a : b;
  const ObservedWall& other = a_first ? b : a;
  const Eigen::Vector2d to = other.center_m - base.center_m;
  const double sigma_m = std::hypot(base.across_sigma_m, other.across_sigma_m,
                                    base.direction_sigma_rad * base.along().dot(to));
  return std::abs(base.across().dot(to)) > std::max(kLeastStepM, kSureSigmas * sigma_m);
}

}  // namespace

Segment WallFilter::seen_in_world(const ObservedWall& observed) const {
  const Pose2 pose = world_from_robot();
  return {pose * observed.start_m, pose * observed.end_m};
}

std::vector<WallMatch> WallFilter::associate(const std::vector<ObservedWall>& observed) const {
  if (options_.association == "similar") return associate_similar(observed);
  const Eigen::Matrix3d p = robot_covariance();
  const double angle_rad = 3.0 * std::sqrt(p(2, 2));
  const double position_m = 3.0 * std::sqrt(std::max(p(0, 0), p(1, 1)));
  const double gate = chi_square_limit(2, options_.gate_probability);

  std::vector<WallMatch> matches(observed.size());
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const Segment seen = seen_in_world(observed[i]);
    // The thesis' limits are for an error within a step; more only where the filter says so.
    SimilarOptions wide = options_.similar;
    wide.max_angle_rad = std::min(0.5, std::max(wide.max_angle_rad, angle_rad));
    wide.max_distance_m =
        std::max(wide.max_distance_m, position_m + angle_rad * observed[i].center_m.norm());
    for (std::size_t j = 0; j < walls_.size(); ++j) {
      if (!state_.is_active(walls_[j].block)) continue;
      const Segment mapped = segment(j);
      if (!slam::similar(seen, mapped, wide)) continue;
      Candidate candidate{static_cast<int>(i), static_cast<int>(j), rows_for(observed[i], j, {})};
      if (individual_distance2(state_, candidate) <= gate) {
        candidates.push_back(std::move(candidate));
      } else if (slam::similar(seen, mapped, options_.similar)) {
        matches[i].wall = WallMatch::kUnclear;
      }
    }
  }
  const std::vector<int> chosen = joint_compatibility(
      state_, candidates, static_cast<int>(observed.size()), options_.gate_probability);
  for (const Candidate& candidate : candidates) {
    matches[static_cast<std::size_t>(candidate.observation)].wall = WallMatch::kUnclear;
  }
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (chosen[i] < 0) continue;
    const Candidate& candidate = candidates[static_cast<std::size_t>(chosen[i])];
    matches[i] = {candidate.wall, individual_distance2(state_, candidate)};
  }
  check_again(observed, matches);
  return matches;
}

// An unsure pose lets walls pair that do not even lie side by side, for the joint test looks across
// walls only. All pairings together say where the robot is: seen from there, each must still be
// `similar`, by the pose's uncertainty that is left. And what the scan itself shows to be two walls
// is not one.
void WallFilter::check_again(const std::vector<ObservedWall>& observed,
                             std::vector<WallMatch>& matches) const {
  Eigen::Matrix3d information = robot_covariance().inverse();
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    const auto index = static_cast<std::size_t>(matches[i].wall);
    const SparseRows rows = rows_for(observed[i], index, {});
    const int block = walls_[index].block;
    const Eigen::Matrix<double, 2, 4> by_wall = rows.jacobian.middleCols<4>(4);
    const Eigen::Matrix2d noise =
        by_wall * state_.covariance(block, block) * by_wall.transpose() + rows.noise;
    const Eigen::Matrix<double, 2, 3> by_robot = rows.jacobian.leftCols<3>();
    const Eigen::Matrix<double, 3, 2> weighted = by_robot.transpose() * noise.inverse();
    information += weighted * by_robot;
    pull += weighted * rows.innovation;
  }
  const Eigen::Matrix3d p = information.inverse();
  const Pose2 pose = Pose2::from_vector(world_from_robot().vector() + p * pull);
  SimilarOptions limits = options_.similar;
  limits.max_angle_rad = std::max(limits.max_angle_rad, 3.0 * std::sqrt(p(2, 2)));
  limits.max_distance_m =
      std::max(limits.max_distance_m, 3.0 * std::sqrt(std::max(p(0, 0), p(1, 1))));
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    const Segment seen{pose * observed[i].start_m, pose * observed[i].end_m};
    bool holds = slam::similar(seen, segment(static_cast<std::size_t>(matches[i].wall)), limits);
    for (std::size_t k = 0; k < observed.size() && holds; ++k) {
      holds = k == i || matches[k].wall != matches[i].wall ||
              matches[k].distance2 > matches[i].distance2 || !are_two(observed[k], observed[i]);
    }
    if (!holds) matches[i] = {WallMatch::kUnclear, 0.0};
  }
}

std::vector<WallMatch> WallFilter::associate_similar(
    const std::vector<ObservedWall>& observed) const {
  std::vector<WallMatch> matches(observed.size());
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const Segment seen = seen_in_world(observed[i]);
    double most_m = 0.0;
    for (std::size_t j = 0; j < walls_.size(); ++j) {
      if (!state_.is_active(walls_[j].block)) continue;
      const Segment mapped = segment(j);
      if (!slam::similar(seen, mapped, options_.similar)) continue;
      const double common_m = std::max(1e-6, overlap_m(seen, mapped));
      if (common_m <= most_m) continue;
      most_m = common_m;
      const Candidate candidate{static_cast<int>(i), static_cast<int>(j),
                                rows_for(observed[i], j, {})};
      matches[i] = {static_cast<int>(j), individual_distance2(state_, candidate)};
    }
  }
  return matches;
}

}  // namespace marco::slam
