#include "slam/back_end/loop_closer.hpp"

#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

// From a place to the keyframes that are matched together with it.
constexpr double kAroundM = 4.0;

double distance_m(const Pose2& a, const Pose2& b) {
  return (a.translation_m() - b.translation_m()).norm();
}

// What is believed of the newest keyframe's pose: so little that it counts only where the walls say
// nothing, as along a bare hall, and a match would be slid along by noise.
Eigen::Matrix3d believed_information(const LoopCandidate& candidate) {
  constexpr double kSigmas = 3.0;  // the window reaches so far
  const double per_m = kSigmas / candidate.shift_m, per_rad = kSigmas / candidate.turn_rad;
  return Eigen::Vector3d(per_m * per_m, per_m * per_m, per_rad * per_rad).asDiagonal();
}

}  // namespace

LoopCloser::LoopCloser(const LoopCloserOptions& options,
                       const CorrelativeMatcher& coarse,
                       const SurfelMatcher& fine)
    : options_(options), coarse_(coarse), fine_(fine) {
  validate(options, "loops");
}

LoopCloser::Drift LoopCloser::drift(double way_m, double since_closed_m) const {
  const double open_m = std::min(way_m, since_closed_m);
  const double shift_m = options_.drift_m + options_.drift_m_per_m * open_m +
                         options_.closed_drift_m_per_m * (way_m - open_m);
  const double part = options_.closed_drift_m_per_m / options_.drift_m_per_m;
  const double turn_deg =
      options_.drift_deg + options_.drift_deg_per_m * (open_m + part * (way_m - open_m));
  return {std::min(options_.max_drift_m, shift_m),
          deg_to_rad(std::min(options_.max_drift_deg, turn_deg))};
}

std::vector<int> LoopCloser::nearby_places(const std::vector<Keyframe>& keys,
                                           const std::vector<double>& shortest_path_lengths_m,
                                           double since_closed_m) const {
  const Keyframe& newest = keys.back();
  struct Place {
    int key;
    double distance_m;
  };
  // The nearest keyframe of each stretch of path that passes by.
  std::vector<Place> places;
  bool in_stretch = false;
  for (std::size_t key = 0; key < keys.size(); ++key) {
    if (newest.path_m - keys[key].path_m < options_.min_path_m) break;
    const double distance = distance_m(keys[key].world_from_robot, newest.world_from_robot);
    if (distance >
        options_.radius_m + drift(shortest_path_lengths_m[key], since_closed_m).shift_m) {
      in_stretch = false;
    } else if (!in_stretch) {
      places.push_back({static_cast<int>(key), distance});
      in_stretch = true;
    } else if (distance < places.back().distance_m) {
      places.back() = {static_cast<int>(key), distance};
    }
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.distance_m < b.distance_m; });
  std::vector<int> result;
  for (const Place& place : places) {
    if (static_cast<int>(result.size()) < options_.candidates) result.push_back(place.key);
  }
  return result;
}

std::vector<LoopCandidate> LoopCloser::candidates(
    const std::vector<Keyframe>& keys,
    double closed_path_m,
    const std::vector<double>& shortest_path_lengths_m) const {
  const Keyframe& newest = keys.back();
  const int to = static_cast<int>(keys.size()) - 1;
  const double since_closed_m = newest.path_m - closed_path_m;
  std::vector<double> drifting_m = shortest_path_lengths_m;
  if (shortest_path_lengths_m.empty()) {
    for (const Keyframe& key : keys) drifting_m.push_back(newest.path_m - key.path_m);
  }
  std::vector<LoopCandidate> found;
  for (const int from : nearby_places(keys, drifting_m, since_closed_m)) {
    const Keyframe& old = keys[static_cast<std::size_t>(from)];
    // Neighbours in the list are neighbours in the building, unless what lay between them was
    // merged into older keyframes.
    const auto belongs = [&](int key) {
      return distance_m(keys[static_cast<std::size_t>(key)].world_from_robot,
                        old.world_from_robot) <= kAroundM;
    };
    int first = from, last = from;
    while (first > 0 && from - first < options_.around && belongs(first - 1)) --first;
    while (last < to && last - from < options_.around && belongs(last + 1)) ++last;
    const int since = std::min(std::max(last + 1, to - options_.around), to);
    const Drift drift = this->drift(drifting_m[static_cast<std::size_t>(from)], since_closed_m);
    found.push_back({from, to, old.world_from_robot, newest.world_from_robot,
                     join_points(keys, first, last, Pose2{}),
                     join_points(keys, since, to, newest.world_from_robot.inverse()), drift.shift_m,
                     drift.turn_rad});
  }
  return found;
}

std::optional<Loop> LoopCloser::verify(const LoopCandidate& candidate) const {
  const SearchWindow window{candidate.world_from_newest, candidate.shift_m, candidate.turn_rad,
                            options_.unlikely_penalty};
  const Eigen::Vector2d centre_m = candidate.world_from_newest.translation_m();
  const LikelihoodPyramid likelihood(points_within(kSearchReachM, centre_m, candidate.place.points),
                                     adapted(coarse_.options(), candidate.place.range_sigma_m));
  const CorrelativeMatch coarse =
      coarse_.search(likelihood, candidate.seen.points, window, options_.min_score);
  if (coarse.score < options_.min_score) return std::nullopt;
  SurfelPyramid surfels(fine_.options(), candidate.world_from_old.translation_m());
  surfels.add(candidate.place, Pose2{});
  const PosePrior believed{candidate.world_from_newest, believed_information(candidate)};
  const SurfelMatch fine = fine_.match(surfels, candidate.seen, coarse.map_from_robot, &believed);
  if (fine.status == SurfelMatch::Status::no_overlap || fine.overlap < options_.min_overlap) {
    return std::nullopt;
  }
  const Eigen::Matrix3d noise =
      diagonal_covariance(options_.sigma_m, deg_to_rad(options_.sigma_deg));
  const Pose2 change = between(candidate.world_from_newest, fine.map_from_robot);
  Loop loop;
  loop.from = candidate.from;
  loop.to = candidate.to;
  loop.information = rotated(with_noise(fine.information, noise), -fine.map_from_robot.theta_rad);
  loop.from_from_to = between(candidate.world_from_old, fine.map_from_robot);
  loop.believed = between(candidate.world_from_old, candidate.world_from_newest);
  loop.score = coarse.score;
  loop.overlap = fine.overlap;
  loop.shift_m = change.translation_m().norm();
  loop.turn_deg = rad_to_deg(change.theta_rad);
  return loop;
}

std::vector<Loop> LoopCloser::find(const std::vector<Keyframe>& keys, double closed_path_m) const {
  std::vector<Loop> loops;
  for (const LoopCandidate& candidate : candidates(keys, closed_path_m)) {
    if (const auto loop = verify(candidate)) loops.push_back(*loop);
  }
  return loops;
}

}  // namespace marco::slam
