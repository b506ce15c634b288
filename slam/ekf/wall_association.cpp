#include <algorithm>
#include <cmath>

#include "slam/ekf/joint_compatibility.hpp"
#include "slam/ekf/wall_filter.hpp"

namespace marco::slam {

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
  return matches;
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
