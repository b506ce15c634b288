#include "slam/line_slam/ekf/data_association.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "slam/line_slam/ekf/joint_compatibility.hpp"

namespace marco::slam {
namespace {

using Matches = std::vector<WallMatch>;
using ObservedWalls = std::vector<ObservedWall>;

// Whether two walls of one scan are certainly apart across; the pose has no part in that.
bool are_two(const ObservedWall& a, const ObservedWall& b) {
  constexpr double kLeastStepM = 0.025;  // smaller steps in a wall are panels and frames
  constexpr double kSureSigmas = 4.0;    // one of 16000 is taken apart wrongly
  const bool a_first = a.num_points >= b.num_points;
  const ObservedWall& base = a_first ? a : b;
  const ObservedWall& other = a_first ? b : a;
  const Eigen::Vector2d to = other.center_m - base.center_m;
  const double sigma_m = std::hypot(base.across_sigma_m, other.across_sigma_m,
                                    base.direction_sigma_rad * base.along().dot(to));
  return std::abs(base.across().dot(to)) > std::max(kLeastStepM, kSureSigmas * sigma_m);
}

// Limits of `similar` for a pose of covariance p: the thesis' limits are for the error of one step.
struct PoseSpread {
  explicit PoseSpread(const Eigen::Matrix3d& p)
      : angle_rad(3.0 * std::sqrt(p(2, 2))),
        position_m(3.0 * std::sqrt(std::max(p(0, 0), p(1, 1)))) {}
  double angle_rad, position_m;
};

Candidate candidate_of(const WallMap& map,
                       const ObservedWalls& observed,
                       std::size_t i,
                       std::size_t j) {
  return {static_cast<int>(i), static_cast<int>(j), map.measurement(observed[i], j, {})};
}

// Candidates that pass the innovation gate; walls that only resemble one are marked unclear.
std::vector<Candidate> find_candidates(const WallMap& map,
                                       const ObservedWalls& observed,
                                       Matches& matches) {
  const PoseSpread spread(map.robot_covariance());
  const SimilarOptions& limits = map.options().similar;
  const double gate = chi_square_limit(2, map.options().gate_probability);
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const Segment seen = map.seen_in_world(observed[i]);
    SimilarOptions wide = limits;
    wide.max_angle_rad = std::min(0.5, std::max(limits.max_angle_rad, spread.angle_rad));
    wide.max_distance_m = std::max(
        limits.max_distance_m, spread.position_m + spread.angle_rad * observed[i].center_m.norm());
    for (std::size_t j = 0; j < map.size(); ++j) {
      const Segment mapped = map.segment(j);
      if (!similar(seen, mapped, wide)) continue;
      Candidate candidate = candidate_of(map, observed, i, j);
      if (individual_distance2(map.state(), candidate) <= gate) {
        candidates.push_back(std::move(candidate));
      } else if (similar(seen, mapped, limits)) {
        matches[i].wall = WallMatch::kUnclear;
      }
    }
  }
  return candidates;
}

// The pose that all pairings together imply, in information form: the walls' errors count as noise.
struct ImpliedPose {
  Pose2 world_from_robot;
  Eigen::Matrix3d covariance;
};

ImpliedPose implied_pose(const WallMap& map,
                         const ObservedWalls& observed,
                         const Matches& matches) {
  Eigen::Matrix3d information = map.robot_covariance().inverse();
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    const auto index = static_cast<std::size_t>(matches[i].wall);
    const SparseRows rows = map.measurement(observed[i], index, {});
    const int block = map.wall(index).block;
    const Eigen::Matrix<double, 2, 4> by_wall = rows.jacobian.middleCols<4>(4);
    const Eigen::Matrix2d noise =
        by_wall * map.state().covariance(block, block) * by_wall.transpose() + rows.noise;
    const Eigen::Matrix<double, 2, 3> by_robot = rows.jacobian.leftCols<3>();
    const Eigen::Matrix<double, 3, 2> weighted = by_robot.transpose() * noise.inverse();
    information += weighted * by_robot;
    pull += weighted * rows.innovation;
  }
  const Eigen::Matrix3d p = information.inverse();
  return {Pose2::from_vector(map.world_from_robot().vector() + p * pull), p};
}

// The joint test looks across walls only, so an uncertain pose lets walls pair that do not even lie
// side by side. Seen from the implied pose each pairing must still be `similar`, within the
// uncertainty that is left. And what the scan itself shows to be two walls is not one.
void check_from_implied_pose(const WallMap& map, const ObservedWalls& observed, Matches& matches) {
  const ImpliedPose implied = implied_pose(map, observed, matches);
  const PoseSpread spread(implied.covariance);
  SimilarOptions limits = map.options().similar;
  limits.max_angle_rad = std::max(limits.max_angle_rad, spread.angle_rad);
  limits.max_distance_m = std::max(limits.max_distance_m, spread.position_m);
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    const Segment seen{implied.world_from_robot * observed[i].start_m,
                       implied.world_from_robot * observed[i].end_m};
    bool holds = similar(seen, map.segment(static_cast<std::size_t>(matches[i].wall)), limits);
    for (std::size_t k = 0; k < observed.size() && holds; ++k) {
      holds = k == i || matches[k].wall != matches[i].wall ||
              matches[k].distance2 > matches[i].distance2 || !are_two(observed[k], observed[i]);
    }
    if (!holds) matches[i] = {WallMatch::kUnclear, 0.0};
  }
}

// The similar wall with the longest overlap.
Matches associate_similar(const WallMap& map, const ObservedWalls& observed) {
  Matches matches(observed.size());
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const Segment seen = map.seen_in_world(observed[i]);
    double most_m = 0.0;
    for (std::size_t j = 0; j < map.size(); ++j) {
      const Segment mapped = map.segment(j);
      if (!similar(seen, mapped, map.options().similar)) continue;
      const double common_m = std::max(1e-6, overlap_m(seen, mapped));
      if (common_m <= most_m) continue;
      most_m = common_m;
      matches[i] = {static_cast<int>(j),
                    individual_distance2(map.state(), candidate_of(map, observed, i, j))};
    }
  }
  return matches;
}

}  // namespace

std::vector<WallMatch> associate_walls(const WallMap& map, const ObservedWalls& observed) {
  if (map.options().association == "similar") return associate_similar(map, observed);
  Matches matches(observed.size());
  const std::vector<Candidate> candidates = find_candidates(map, observed, matches);
  const std::vector<int> chosen = joint_compatibility(
      map.state(), candidates, static_cast<int>(observed.size()), map.options().gate_probability);
  for (const Candidate& candidate : candidates) {
    matches[static_cast<std::size_t>(candidate.observation)].wall = WallMatch::kUnclear;
  }
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (chosen[i] < 0) continue;
    const Candidate& candidate = candidates[static_cast<std::size_t>(chosen[i])];
    matches[i] = {candidate.wall, individual_distance2(map.state(), candidate)};
  }
  check_from_implied_pose(map, observed, matches);
  return matches;
}

}  // namespace marco::slam
