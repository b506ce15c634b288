#include "slam/front_end/scan_matcher.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

using namespace match_gates;

SearchWindow window_of(const PosePrior& prior) {
  const Eigen::Matrix3d covariance = covariance_of(prior.information);
  const double sigma_m = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
  const double sigma_rad = std::sqrt(covariance(2, 2));
  return {prior.map_from_robot, std::clamp(kSigmas * sigma_m, kNarrowestM, kWidestM),
          std::clamp(kSigmas * sigma_rad, deg_to_rad(kNarrowestDeg), deg_to_rad(kWidestDeg))};
}

bool contradicts(const ScanMatch& match, const PosePrior& prior) {
  const Eigen::Vector3d off = difference(match.world_from_robot, prior.map_from_robot);
  return squared_mahalanobis_distance(off, prior.information) > kContradiction;
}

}  // namespace

bool proves_lie(double overlap_there, double overlap_by_odometry, double points) {
  const auto variance = [&](double part) { return part * (1.0 - part) / points; };
  const double sigma = std::sqrt(variance(overlap_there) + variance(overlap_by_odometry));
  return overlap_there - overlap_by_odometry > std::max(kProvesLie, kNoChanceSigmas * sigma);
}

ScanMatcher::ScanMatcher(const MatchGateOptions& gates,
                         const SurfelMatcherOptions& fine,
                         const CorrelativeMatcherOptions& coarse)
    : gates_(gates), fine_(fine), coarse_(coarse) {}

ScanMatch ScanMatcher::judged(const SurfelMatch& fine) const {
  return {fine.map_from_robot, fine.information, fine.overlap,
          fine.status != SurfelMatch::Status::no_overlap && fine.overlap >= gates_.poor_overlap,
          fine.misfit_m2};
}

ScanMatch ScanMatcher::match_again(const OrientedPoints& points,
                                   const Pose2& world_from_robot,
                                   const PosePrior& prior,
                                   const LocalMap& map) const {
  return judged(fine_.match(map.surfels(), points, world_from_robot, &prior));
}

ScanMatch ScanMatcher::match(const OrientedPoints& points,
                             const PosePrior& prior,
                             MotionGuess::Source source,
                             const KeyframeSet& keyframes,
                             LocalMap& map,
                             Search search) const {
  if (points.points.cols() < gates_.min_points) return match_few(points, prior, map);
  ScanMatch near = match_again(points, prior.map_from_robot, prior, map);
  if (source == MotionGuess::Source::odometry &&
      (near.overlap < gates_.sure_overlap || contradicts(near, prior))) {
    near = or_freely(near, points, prior, map);
  }
  if (near.overlap >= gates_.good_overlap && source == MotionGuess::Source::odometry) return near;
  const LikelihoodPyramid& likelihood = map.likelihood(keyframes);
  ScanMatch wide = match_widely(points, window_of(prior), prior, likelihood, map);
  if (wide.usable && wide.overlap > near.overlap + kClearlyBetter) return wide;
  if (near.usable || search == Search::prior_window) return near;
  PosePrior weak = prior;
  weak.information *= kDoubtedPrior;
  const SearchWindow widest{prior.map_from_robot, kWidestM, deg_to_rad(kWidestDeg)};
  ScanMatch alone = match_widely(points, widest, weak, likelihood, map);
  if (alone.usable && alone.overlap >= gates_.good_overlap) return alone;
  near.world_from_robot = prior.map_from_robot;
  near.information.setZero();
  return near;
}

ScanMatch ScanMatcher::match_few(const OrientedPoints& points,
                                 const PosePrior& prior,
                                 const LocalMap& map) const {
  // A single column does not constrain the heading, for it looks the same from all sides; but the
  // match claims to know it.
  constexpr double kOneObjectM = 1.0;  // root mean square of the distances from the middle
  constexpr double kHeldRad = 1e-4;
  const Eigen::Vector2d middle_m = points.points.rowwise().mean();
  const double spread2 = (points.points.colwise() - middle_m).colwise().squaredNorm().mean();
  if (spread2 > kOneObjectM * kOneObjectM) {
    return match_again(points, prior.map_from_robot, prior, map);
  }
  PosePrior held{prior.map_from_robot, prior.information};
  held.information(2, 2) += 1.0 / (kHeldRad * kHeldRad);
  ScanMatch match = match_again(points, prior.map_from_robot, held, map);
  match.information.row(2).setZero();
  match.information.col(2).setZero();
  return match;
}

ScanMatch ScanMatcher::or_freely(const ScanMatch& near,
                                 const OrientedPoints& points,
                                 const PosePrior& prior,
                                 const LocalMap& map) const {
  PosePrior weak = prior;
  weak.information *= kDoubtedPrior;
  const ScanMatch start = match_again(points, prior.map_from_robot, weak, map);
  const ScanMatch free =
      judged(fine_.refined(map.surfels(), points, start.world_from_robot, prior));
  return free.usable && cost(free, points, prior) < cost(near, points, prior) ? free : near;
}

double ScanMatcher::cost(const ScanMatch& match,
                         const OrientedPoints& points,
                         const PosePrior& prior) const {
  const double sigma_m = std::max(fine_.options().noise_floor_m, points.range_sigma_m);
  const double independent =
      static_cast<double>(points.points.cols()) / fine_.options().correlated_points;
  return independent * match.misfit_m2 / (2.0 * sigma_m * sigma_m) +
         prior.cost(difference(match.world_from_robot, prior.map_from_robot));
}

ScanMatch ScanMatcher::match_widely(const OrientedPoints& points,
                                    const SearchWindow& window,
                                    const PosePrior& prior,
                                    const LikelihoodPyramid& likelihood,
                                    const LocalMap& map) const {
  const CorrelativeMatch coarse =
      coarse_.search(likelihood, points.points, window, kMinSearchScore);
  if (coarse.score <= 0.0) return {};
  return judged(fine_.match(map.surfels(), points, coarse.map_from_robot, &prior));
}

}  // namespace marco::slam
