#include "slam/matching/surfel_matcher.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// 1 - w at e = 3 sigma: losing a correspondence must not lower the cost.
constexpr double kUnmatchedCost = 1.0 - 1.0 / 5.5;

// Steps with the same correspondences before they are searched again.
constexpr int kInnerSteps = 2;

/// Standard deviation of the normals of a scan's points [rad]. Their noise makes a bare corridor
/// look constrained along itself.
constexpr double kNormalSigma = 0.06;

/// The direction of translation that a sum of point-to-line constraints, w j j^T with
/// j = (n_x, n_y, arm x n), constrains least; the heading is marginalized.
struct WeakestDirection {
  Eigen::Vector2d direction;  ///< unit length
  double information;         ///< along it, at least 0
  /// The part that the noise of normals explains: kNormalSigma^2 sum w (t . direction)^2, t along
  /// the wall. At most `information`.
  double by_noise;

  explicit WeakestDirection(const Eigen::Matrix3d& sum) {
    const double turn = sum(2, 2) > 0.0 ? 1.0 / sum(2, 2) : 0.0;
    const double xx = sum(0, 0) - turn * sum(0, 2) * sum(0, 2);
    const double xy = sum(0, 1) - turn * sum(0, 2) * sum(1, 2);
    const double yy = sum(1, 1) - turn * sum(1, 2) * sum(1, 2);
    information = std::max(0.0, 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy));
    const double angle = 0.5 * std::atan2(-2.0 * xy, yy - xx);
    direction = {std::cos(angle), std::sin(angle)};
    const double x = direction.x(), y = direction.y();
    const double along = x * x * sum(1, 1) - 2.0 * x * y * sum(0, 1) + y * y * sum(0, 0);
    by_noise = std::min(information, kNormalSigma * kNormalSigma * along);
  }

  double honest() const { return information - by_noise; }
  /// The sum without by_noise; positive semidefinite as the sum was.
  Eigen::Matrix3d without_noise(Eigen::Matrix3d sum) const {
    sum.topLeftCorner<2, 2>() -= by_noise * direction * direction.transpose();
    return sum;
  }
};

Pose2 seen_from(const Eigen::Vector2d& centre_m, const Pose2& pose) {
  return {pose.x_m - centre_m.x(), pose.y_m - centre_m.y(), pose.theta_rad};
}

Pose2 moved(const Pose2& pose, const Eigen::Vector3d& step) {
  return {pose.x_m + step.x(), pose.y_m + step.y(), normalize_angle(pose.theta_rad + step.z())};
}

// Solves a symmetric positive definite 3x3 system by Cholesky; reads the upper triangle only.
Eigen::Vector3d solved(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) {
  const double l00 = std::sqrt(a(0, 0)), l10 = a(0, 1) / l00, l20 = a(0, 2) / l00;
  const double l11 = std::sqrt(a(1, 1) - l10 * l10), l21 = (a(1, 2) - l20 * l10) / l11;
  const double l22 = std::sqrt(a(2, 2) - l20 * l20 - l21 * l21);
  const double y0 = b(0) / l00, y1 = (b(1) - l10 * y0) / l11;
  const double y2 = (b(2) - l20 * y0 - l21 * y1) / l22;
  const double x2 = y2 / l22, x1 = (y1 - l21 * x2) / l11;
  return {(y0 - l10 * x1 - l20 * x2) / l00, x1, x2};
}

// Solution remapping (Zhang, Kaess, Singh, "On degeneracy of optimization-based state estimation
// problems", ICRA 2016): along a degenerate direction the prior replaces the match. What differs:
// degenerate means that most of its information is noise, and the rest still counts, by its weight
// against the prior's. A direction that walls constrain only weakly is not degenerate, or wheels
// that err by centimetres a scan would win.
Pose2 remap_degenerate_direction(const Pose2& pose,
                                 const PosePrior& prior,
                                 const WeakestDirection& weakest,
                                 double sigma2) {
  const Eigen::Vector2d& along = weakest.direction;
  const double expected = sigma2 * along.dot(prior.information.topLeftCorner<2, 2>() * along);
  const double honest = weakest.honest();
  if (!(expected > 0.0 && weakest.information > 0.0) || honest > weakest.by_noise) return pose;
  const double kept =
      honest / (honest + expected) * (weakest.information + expected) / weakest.information;
  const Eigen::Vector2d off(pose.x_m - prior.map_from_robot.x_m,
                            pose.y_m - prior.map_from_robot.y_m);
  const Eigen::Vector2d back = (1.0 - kept) * along.dot(off) * along;
  return {pose.x_m - back.x(), pose.y_m - back.y(), pose.theta_rad};
}

}  // namespace

struct SurfelMatcher::Level {
  const SurfelMap& map;
  double sigma_m;
  double stop_below_m, stop_below_rad;
  double keep_below_m, keep_below_rad;
  const PosePrior* prior;  // seen from the map's centre, null = none

  bool within(const Eigen::Vector3d& step, double limit_m, double limit_rad) const {
    return step.head<2>().squaredNorm() < limit_m * limit_m && std::abs(step.z()) < limit_rad;
  }
  Eigen::Vector3d off_prior(const Pose2& pose) const {
    const Pose2& expected = prior->map_from_robot;
    return {pose.x_m - expected.x_m, pose.y_m - expected.y_m,
            normalize_angle(pose.theta_rad - expected.theta_rad)};
  }
  Eigen::Vector3d step(const NormalSums& sums, const Pose2& pose, double lambda) const {
    Eigen::Matrix3d matrix = sums.matrix();
    Eigen::Vector3d right = sums.right();
    if (prior != nullptr) {
      const double scale = sigma_m * sigma_m;
      const Eigen::Vector3d off = off_prior(pose);
      const Eigen::Matrix3d information = scale * prior->weight(off) * prior->information;
      matrix += information;
      right += information * off;
    }
    // An unobservable direction must not move, not even by the rounding of floats.
    matrix.diagonal() += lambda * matrix.diagonal();
    matrix.diagonal().array() += 1e-6;
    const Eigen::Vector3d result = -solved(matrix, right);
    return result.allFinite() ? result : Eigen::Vector3d::Zero();
  }
  double cost(const Correspondences& points, const NormalSums& sums, const Pose2& pose) const {
    const double matched = points.count() - sums.weights;
    const double unmatched = kUnmatchedCost * (points.count() - points.matched());
    if (prior == nullptr) return matched + unmatched;
    return matched + unmatched + prior->cost(off_prior(pose));
  }
};

double PosePrior::weight(const Eigen::Vector3d& off) const {
  if (freedom <= 0.0) return 1.0;
  return (freedom + 3.0) / (freedom + off.dot(information * off));
}

double PosePrior::cost(const Eigen::Vector3d& off) const {
  const double distance2 = off.dot(information * off);
  if (freedom <= 0.0) return 0.5 * distance2;
  return 0.5 * (freedom + 3.0) * std::log1p(distance2 / freedom);
}

SurfelPyramid::SurfelPyramid(const SurfelMatcherOptions& options, const Eigen::Vector2d& centre_m) {
  levels_.reserve(options.cells_m.size());
  for (const double cell_m : options.cells_m) {
    levels_.emplace_back(centre_m, options.half_width_m, cell_m);
  }
}

void SurfelPyramid::restart(const Eigen::Vector2d& centre_m) {
  for (SurfelMap& level : levels_) level.restart(centre_m);
}

double SurfelPyramid::add(const OrientedPoints& points, const Pose2& map_from_points) {
  double of_before = 0.0;
  for (SurfelMap& level : levels_) of_before = level.add(points, map_from_points);
  return of_before;
}

SurfelMatcher::SurfelMatcher(const SurfelMatcherOptions& options) : options_(options) {
  validate(options, "surfel_matcher");
  require(!options.cells_m.empty() && options.cells_m.size() == options.sigmas_m.size() &&
              options.cells_m.size() == options.every_nth_point.size(),
          "surfel_matcher: cells_m, sigmas_m and every_nth_point need one value per level each");
}

double SurfelMatcher::kernel_sigma_m(std::size_t level, double range_sigma_m) const {
  // Residuals hold the noise of the range and of the surfel's line; coarser levels a guess's error.
  constexpr double kFinestSigmas = 1.2, kCoarserSigmas = 2.0;
  const bool finest = level + 1 == options_.sigmas_m.size();
  return std::max(options_.sigmas_m[level],
                  (finest ? kFinestSigmas : kCoarserSigmas) * range_sigma_m);
}

void SurfelMatcher::run_level(const Level& level,
                              Correspondences& points,
                              SurfelMatch& match) const {
  Pose2& pose = match.map_from_robot;
  points.associate(level.map, pose);
  NormalSums sums = points.sum(pose, level.sigma_m);
  double cost = level.cost(points, sums, pose);
  double lambda = 1e-4;
  bool keep_matches = false;
  match.status = SurfelMatch::Status::iteration_limit;
  for (int i = 0; i < options_.max_iterations; ++i) {
    ++match.iterations;
    Eigen::Vector3d step = level.step(sums, pose, lambda), whole = step;
    Pose2 next = moved(pose, step);
    for (int inner = 1; inner < kInnerSteps; ++inner) {
      step = level.step(points.sum(next, level.sigma_m), next, lambda);
      next = moved(next, step);
      whole += step;
    }
    if (level.within(whole, level.stop_below_m, level.stop_below_rad)) {
      pose = next;
      match.status = SurfelMatch::Status::converged;
      return;
    }
    keep_matches = keep_matches || level.within(whole, level.keep_below_m, level.keep_below_rad);
    if (!keep_matches) points.associate(level.map, next);
    const NormalSums next_sums = points.sum(next, level.sigma_m);
    const double next_cost = level.cost(points, next_sums, next);
    if (keep_matches || next_cost <= cost) {
      pose = next;
      sums = next_sums;
      cost = next_cost;
      lambda = std::max(lambda * 0.1, 1e-7);
      continue;
    }
    if (lambda > 1e3) return;
    points.associate(level.map, pose);
    lambda = std::max(lambda * 10.0, 1e-2);
  }
}

SurfelMatch SurfelMatcher::match(const SurfelPyramid& map,
                                 const OrientedPoints& points_in_robot,
                                 const Pose2& map_from_robot_guess,
                                 const PosePrior* prior,
                                 std::vector<PointFate>* fates) const {
  return match_from(0, map, points_in_robot, map_from_robot_guess, prior, fates);
}

SurfelMatch SurfelMatcher::refined(const SurfelPyramid& map,
                                   const OrientedPoints& points_in_robot,
                                   const Pose2& map_from_robot,
                                   const PosePrior& prior) const {
  return match_from(map.levels().size() - 1, map, points_in_robot, map_from_robot, &prior, nullptr);
}

SurfelMatch SurfelMatcher::match_from(std::size_t first_level,
                                      const SurfelPyramid& map,
                                      const OrientedPoints& points_in_robot,
                                      const Pose2& map_from_robot_guess,
                                      const PosePrior* prior,
                                      std::vector<PointFate>* fates) const {
  SurfelMatch match;
  match.map_from_robot = map_from_robot_guess;
  if (fates != nullptr) fates->clear();
  if (points_in_robot.points.cols() == 0) return match;
  const Eigen::Vector2d centre_m = map.levels().front().centre_m();
  PosePrior seen_prior;
  if (prior != nullptr) {
    seen_prior = *prior;
    seen_prior.map_from_robot = seen_from(centre_m, prior->map_from_robot);
  }
  match.map_from_robot = seen_from(centre_m, map_from_robot_guess);
  const std::size_t finest = map.levels().size() - 1;
  for (std::size_t at = first_level; at <= finest; ++at) {
    const double sigma_m = kernel_sigma_m(at, points_in_robot.range_sigma_m);
    const double coarse_stop = options_.coarse_stop_sigmas * sigma_m;
    const bool last = at == finest;
    const Level level{map.levels()[at],
                      sigma_m,
                      last ? options_.stop_below_m : coarse_stop,
                      last ? deg_to_rad(options_.stop_below_deg) : coarse_stop,
                      last ? options_.keep_walls_below_m : 0.0,
                      last ? deg_to_rad(options_.keep_walls_below_deg) : 0.0,
                      prior != nullptr ? &seen_prior : nullptr};
    Correspondences points(points_in_robot,
                           static_cast<Eigen::Index>(options_.every_nth_point[at]));
    run_level(level, points, match);
    if (!last) continue;
    Pose2 centre_from_robot = match.map_from_robot;
    match.map_from_robot = map_from_robot_guess;
    if (options_.every_nth_point[at] > 1.0) {
      points = Correspondences(points_in_robot, 1);
      points.associate(level.map, centre_from_robot);
    }
    if (prior != nullptr) {
      const WeakestDirection weakest(points.sum(centre_from_robot, sigma_m).matrix());
      centre_from_robot =
          remap_degenerate_direction(centre_from_robot, seen_prior, weakest, sigma_m * sigma_m);
    }
    if (judge(points, centre_from_robot, sigma_m, match, fates)) {
      match.map_from_robot = centre_from_robot;
      match.map_from_robot.x_m += centre_m.x();
      match.map_from_robot.y_m += centre_m.y();
    } else {
      match.status = SurfelMatch::Status::no_overlap;
    }
  }
  return match;
}

bool SurfelMatcher::judge(const Correspondences& points,
                          const Pose2& centre_from_robot,
                          double sigma_m,
                          SurfelMatch& match,
                          std::vector<PointFate>* fates) const {
  const auto limit_m = static_cast<float>(3.0 * sigma_m);
  std::vector<float> distances_m;
  points.distances_m(centre_from_robot, distances_m);
  double near = 0.0, squares = 0.0;
  for (const float distance_m : distances_m) {
    if (!(std::abs(distance_m) <= limit_m)) continue;
    near += 1.0;
    squares += static_cast<double>(distance_m * distance_m);
  }
  if (fates != nullptr) {
    fates->reserve(distances_m.size());
    for (const float distance_m : distances_m) {
      fates->push_back(std::isnan(distance_m)            ? PointFate::no_wall
                       : std::abs(distance_m) <= limit_m ? PointFate::on_wall
                                                         : PointFate::off_wall);
    }
  }
  match.overlap = near / points.count();
  match.misfit_m2 = squares / points.count() + (1.0 - match.overlap) * 9.0 * sigma_m * sigma_m;
  if (near < 3.0) return false;
  match.rms_m = std::sqrt(squares / near);
  const double noise_m = std::max(match.rms_m, options_.noise_floor_m);
  const Eigen::Matrix3d sum = points.sum(centre_from_robot, sigma_m).matrix();
  match.information =
      WeakestDirection(sum).without_noise(sum) / (noise_m * noise_m * options_.correlated_points);
  return true;
}

}  // namespace marco::slam
