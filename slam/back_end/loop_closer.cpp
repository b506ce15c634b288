#include "slam/back_end/loop_closer.hpp"

#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"
#include "slam/back_end/loop_gates.hpp"
#include "slam/map/place_view.hpp"

namespace marco::slam {
namespace {

// From a place to the keyframes that are matched together with it.
constexpr double kAroundM = 4.0;

double distance_m(const Pose2& a, const Pose2& b) {
  return (a.translation_m() - b.translation_m()).norm();
}

// Keyframes less sure of each other are not matched together: something is missing between them.
constexpr double kQueryShiftM = 1.0;

// A search reaches so far, in standard deviations of the pose.
constexpr double kSigmas = 3.0;

// What the graph's edges do not know, as standard deviations: a constant part, and scan matching's
// bias, which grows with the way: 0.17 deg/m where a laser sees 4 m of a building. Closing a loop
// takes most of it away.
constexpr double kUnknownM = 0.1, kUnknownDeg = 1.4;
constexpr double kBiasMPerM = 0.01, kBiasDegPerM = 0.1;
constexpr double kClosedBias = 1.0 / 6.0;

Eigen::Matrix3d with_bias(const RelativeUncertainty& known, double since_closed_m) {
  const double open_m = std::min(known.way_m, since_closed_m);
  const double biased_m = open_m + kClosedBias * (known.way_m - open_m);
  return known.covariance + diagonal_covariance(kUnknownM, deg_to_rad(kUnknownDeg)) +
         diagonal_covariance(kBiasMPerM * biased_m, deg_to_rad(kBiasDegPerM * biased_m));
}

using namespace loop_gates;

// Of keys[first] to keys[last], evenly.
std::vector<Keyframe> some_of(const std::vector<Keyframe>& keys, int first, int last) {
  constexpr int kMost = 6;  // keyframes: their views overlap, and every point is held against each
  const int step = (last - first) / kMost + 1;
  std::vector<Keyframe> some;
  for (int key = last; key >= first; key -= step) {
    some.push_back(keys[static_cast<std::size_t>(key)]);
  }
  return some;
}

constexpr Eigen::Index kFewestPoints = 50;  // in view: of fewer, some are always in the way
// Searches among the points in view; each begins where the one before ended. Without them, of 2 km
// through one building 11 loops of 2291 are untrue instead of 1 of 2398.
constexpr int kRoundsInView = 2;

// The points that the older visit could see, were they seen from that pose; all of them, where it
// is not known what it could see.
OrientedPoints in_view_of(const PlaceView& place,
                          const OrientedPoints& points,
                          const Pose2& world_from_points) {
  const std::vector<bool> seen = place.sees(points.points, world_from_points);
  OrientedPoints some = points;
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < points.points.cols(); ++i) {
    if (!seen[static_cast<std::size_t>(i)]) continue;
    some.points.col(count) = points.points.col(i);
    some.normals.col(count++) = points.normals.col(i);
  }
  if (count < kFewestPoints) return points;
  some.points.conservativeResize(2, count);
  some.normals.conservativeResize(2, count);
  return some;
}

}  // namespace

std::vector<RelativeUncertainty> uncertainties_by_path(const std::vector<Keyframe>& keys) {
  std::vector<RelativeUncertainty> uncertainties(keys.size());
  for (std::size_t key = 0; key < keys.size(); ++key) {
    uncertainties[key].way_m = keys.back().path_m - keys[key].path_m;
  }
  return uncertainties;
}

LoopCloser::LoopCloser(const LoopCloserOptions& options,
                       const CorrelativeMatcher& coarse,
                       const SurfelMatcher& fine)
    : options_(options), coarse_(coarse), fine_(fine) {
  validate(options, "loops");
}

double LoopCloser::shift_m(const Eigen::Matrix3d& covariance) const {
  return std::min(kSigmas * position_sigma_m(covariance), options_.max_drift_m);
}

double LoopCloser::turn_rad(const Eigen::Matrix3d& covariance) const {
  return std::min(kSigmas * std::sqrt(covariance(2, 2)), deg_to_rad(options_.max_drift_deg));
}

double LoopCloser::max_variance_m2() const {
  const double sigma_m = options_.max_drift_m / kSigmas;
  return 2.0 * sigma_m * sigma_m;
}

bool LoopCloser::may_have_candidates(const std::vector<Keyframe>& keys) const {
  const Keyframe& newest = keys.back();
  const double reach_m = options_.radius_m + options_.max_drift_m;
  return std::any_of(keys.begin(), keys.end(), [&](const Keyframe& key) {
    return newest.path_m - key.path_m >= options_.min_path_m &&
           distance_m(key.world_from_robot, newest.world_from_robot) <= reach_m;
  });
}

std::vector<int> LoopCloser::nearby_places(const std::vector<Keyframe>& keys,
                                           const std::vector<Eigen::Matrix3d>& covariances) const {
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
    const double reach_m = shift_m(covariances[key]);
    if (distance > options_.radius_m + reach_m) {
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
    const std::vector<RelativeUncertainty>& uncertainties,
    double closed_path_m) const {
  const Keyframe& newest = keys.back();
  const int to = static_cast<int>(keys.size()) - 1;
  std::vector<Eigen::Matrix3d> covariances;
  covariances.reserve(keys.size());
  for (const RelativeUncertainty& known : uncertainties) {
    covariances.push_back(with_bias(known, newest.path_m - closed_path_m));
  }
  std::vector<LoopCandidate> found;
  for (const int from : nearby_places(keys, covariances)) {
    const Keyframe& old = keys[static_cast<std::size_t>(from)];
    // The query is as long as the search is wide: a match is worth no more than its extent (Olson,
    // "Robust and efficient robotic mapping", 2008, ch. 4). The place holds it wherever it may lie,
    // and what is next to it: a rival. Neighbours in the list are neighbours in the building,
    // unless what lay between them was merged into older keyframes.
    const Eigen::Matrix3d& covariance = covariances[static_cast<std::size_t>(from)];
    const double reach_m = shift_m(covariance);
    const auto in_place = [&](int key) {
      const Keyframe& other = keys[static_cast<std::size_t>(key)];
      return distance_m(other.world_from_robot, old.world_from_robot) <= kAroundM + 2.0 * reach_m &&
             (std::abs(key - from) <= options_.around ||
              std::abs(other.path_m - old.path_m) <= 2.0 * reach_m);
    };
    const auto in_query = [&](int key) {
      const auto at = static_cast<std::size_t>(key);
      return shift_m(covariances[at]) <= kQueryShiftM &&
             (to - key <= options_.around || newest.path_m - keys[at].path_m <= reach_m);
    };
    int first = from, last = from, since = to;
    while (first > 0 && in_place(first - 1)) --first;
    while (last < to && in_place(last + 1)) ++last;
    while (since > last + 1 && in_query(since - 1)) --since;
    found.push_back({from, to, old.world_from_robot, newest.world_from_robot,
                     join_points(keys, first, last, Pose2{}),
                     join_points(keys, since, to, newest.world_from_robot.inverse()), covariance,
                     some_of(keys, first, last)});
  }
  return found;
}

std::optional<Loop> LoopCloser::verify(const LoopCandidate& candidate) const {
  const SearchWindow window{candidate.world_from_newest, shift_m(candidate.covariance),
                            turn_rad(candidate.covariance), options_.unlikely_penalty};
  const Eigen::Vector2d centre_m = candidate.world_from_newest.translation_m();
  const LikelihoodPyramid likelihood(points_within(kSearchReachM, centre_m, candidate.place.points),
                                     adapted(coarse_.options(), candidate.place.range_sigma_m));
  CorrelativeMatch coarse =
      coarse_.search(likelihood, candidate.seen.points, window, options_.min_score);
  if (coarse.score < options_.min_score) return std::nullopt;
  const double score = coarse.score;
  // A search over all points gains by each wall that it pushes onto the part of it that the older
  // visit saw. Points that this visit could see at either pose do not favour one of them.
  const PlaceView place(candidate.place_keys);
  const OrientedPoints by_path = in_view_of(place, candidate.seen, candidate.world_from_newest);
  for (int round = 0; round < kRoundsInView; ++round) {
    const OrientedPoints by_both = in_view_of(place, by_path, coarse.map_from_robot);
    const CorrelativeMatch again =
        coarse_.search(likelihood, by_both.points, window, options_.min_score);
    if (again.score < options_.min_score) break;
    coarse = again;
  }
  SurfelPyramid surfels(fine_.options(), candidate.world_from_old.translation_m());
  surfels.add(candidate.place, Pose2{});
  const double heading_rad = candidate.world_from_newest.theta_rad;
  // So little that it counts only where the walls say nothing, as along a bare hall.
  const PosePrior believed{candidate.world_from_newest,
                           information_of(rotated(candidate.covariance, heading_rad))};
  const OrientedPoints seen_there = in_view_of(place, candidate.seen, coarse.map_from_robot);
  const SurfelMatch fine = fine_.match(surfels, seen_there, coarse.map_from_robot, &believed);
  if (fine.status == SurfelMatch::Status::no_overlap || fine.overlap < options_.min_overlap) {
    return std::nullopt;
  }
  if (has_rival(likelihood, candidate, window, coarse, fine.information)) return std::nullopt;
  const Pose2 change = between(candidate.world_from_newest, fine.map_from_robot);
  const Eigen::Matrix3d noise =
      diagonal_covariance(options_.sigma_m, deg_to_rad(options_.sigma_deg));
  Loop loop;
  loop.from = candidate.from;
  loop.to = candidate.to;
  loop.information = rotated(with_noise(fine.information, noise), -fine.map_from_robot.theta_rad);
  loop.from_from_to = between(candidate.world_from_old, fine.map_from_robot);
  loop.believed = between(candidate.world_from_old, candidate.world_from_newest);
  loop.score = score;
  loop.overlap = fine.overlap;
  loop.shift_m = change.translation_m().norm();
  loop.turn_deg = rad_to_deg(change.theta_rad);
  return loop;
}

bool LoopCloser::has_rival(const LikelihoodPyramid& likelihood,
                           const LoopCandidate& candidate,
                           const SearchWindow& window,
                           const CorrelativeMatch& best,
                           const Eigen::Matrix3d& information) const {
  if (window.half_width_m < 2.0 * kRivalM) return false;
  SearchWindow elsewhere = window;
  elsewhere.excluded = {best.map_from_robot, kRivalM, deg_to_rad(kRivalDeg)};
  const CorrelativeMatch rival = coarse_.search(likelihood, candidate.seen.points, elsewhere,
                                                best.score - best.penalty - kRivalMargin);
  if (rival.score <= 0.0) return false;
  // Along a corridor every place fits: there the match does not claim to know.
  const Eigen::Vector3d apart = difference(rival.map_from_robot, best.map_from_robot);
  // A match that knows its place knows that it is not as near as a rival may be.
  const Eigen::Matrix3d noise =
      diagonal_covariance(kRivalM / std::sqrt(kChi2Dof3Quantile999), deg_to_rad(kRivalDeg));
  return squared_mahalanobis_distance(apart, with_noise(information, noise)) > kChi2Dof3Quantile999;
}

std::vector<Loop> LoopCloser::find(const std::vector<Keyframe>& keys,
                                   const std::vector<RelativeUncertainty>& uncertainties,
                                   double closed_path_m) const {
  std::vector<Loop> loops;
  for (const LoopCandidate& candidate : candidates(keys, uncertainties, closed_path_m)) {
    if (const auto loop = verify(candidate)) loops.push_back(*loop);
  }
  return loops;
}

}  // namespace marco::slam
