#include "slam/matching/nlm_matcher.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace marco::slam {

NlmSystem nlm_system(const std::vector<PointPair>& pairs,
                     const Pose2& target_from_source,
                     const Estimator& estimator) {
  const Eigen::Matrix2d rotation = target_from_source.rotation();
  const Eigen::Vector2d translation = target_from_source.translation_m();
  NlmSystem system;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector2d turned = rotation * pair.source;
    const Eigen::Vector2d e = turned + translation - pair.target;  // (3.6)
    const Eigen::Vector2d by_theta(-turned.y(), turned.x());
    for (int axis = 0; axis < 2; ++axis) {
      const double influence = estimator.influence(e[axis]);
      const double curvature = estimator.curvature(e[axis]);
      const double weight = estimator.weight(e[axis]);
      const double d = by_theta[axis];
      system.error += estimator.rho(e[axis]);
      system.gradient[0] += influence * d;
      system.gradient[1 + axis] += influence;
      // (3.9): e e_pq / D + e_p e_q (D - 2 e²) / D²; x'_theta,theta is -turned.
      system.hessian(0, 0) += curvature * d * d - influence * turned[axis];
      system.hessian(0, 1 + axis) += curvature * d;
      system.hessian(1 + axis, 1 + axis) += curvature;
      system.damping[0] += weight * d * d;
      system.damping[1 + axis] += weight;
    }
  }
  system.hessian(1, 0) = system.hessian(0, 1);
  system.hessian(2, 0) = system.hessian(0, 2);
  return system;
}

struct NlmMatcher::Run {
  const NlmTarget& target;
  const Points2& source;
  Pose2 pose;
  std::vector<PointPair> pairs;
  std::vector<int> partners;
  int unmatched = 0;
  int iterations = 0;
  MatchStatus status = MatchStatus::iteration_limit;

  /// Data association at `pose` (3.4.1), with lines if the option is set.
  void associate(const NlmOptions& options) {
    pairs.clear();
    partners.clear();
    unmatched = 0;
    const Eigen::Matrix2d rotation = pose.rotation();
    for (const auto& point : source.colwise()) {
      const Eigen::Vector2d moved = rotation * point + pose.translation_m();
      const auto near = target.index().nearest(moved, options.max_pair_m);
      if (!near) {
        ++unmatched;
        continue;
      }
      if (options.calculated_points) {
        const auto partner = target.lines().partner(moved, near.index);
        pairs.push_back({point, partner.point});
      } else {
        pairs.push_back({point, target.index().points().col(near.index)});
      }
      partners.push_back(near.index);
    }
  }
};

namespace {

double total_error(const NlmSystem& system,
                   int unmatched,
                   const NlmOptions& options,
                   const Estimator& estimator) {
  // A point without a correspondence costs as much as one at the limit, split over both axes.
  return system.error + 2.0 * unmatched * estimator.rho(options.max_pair_m / std::sqrt(2.0));
}

}  // namespace

NlmMatcher::NlmMatcher(NlmOptions options)
    : options_(std::move(options)), kind_(estimator_kind(options_.estimator)) {
  validate(options_, "nlm_matcher");
  require(!options_.sigma_schedule_m.empty(), "nlm_matcher.sigma_schedule_m is empty");
}

void NlmMatcher::descend(Run& run, const Estimator& estimator) const {
  run.associate(options_);
  NlmSystem system = nlm_system(run.pairs, run.pose, estimator);
  double error = total_error(system, run.unmatched, options_, estimator);
  double lambda = options_.lambda_start;
  run.status = MatchStatus::iteration_limit;
  for (int accepted = 0; accepted < options_.max_iterations;) {
    if (lambda > options_.lambda_max) {
      run.status = MatchStatus::converged;
      return;
    }
    Eigen::Matrix3d damped = system.hessian;
    damped.diagonal() += lambda * system.damping;
    const Eigen::LLT<Eigen::Matrix3d> llt(damped);
    if (llt.info() != Eigen::Success) {
      lambda *= 10.0;
      continue;
    }
    const Eigen::Vector3d step = -llt.solve(system.gradient);  // (3.8)
    Run trial{run.target, run.source, run.pose, {}, {}};
    trial.pose = {run.pose.x_m + step[1], run.pose.y_m + step[2],
                  normalize_angle(run.pose.theta_rad + step[0])};
    trial.associate(options_);
    NlmSystem trial_system = nlm_system(trial.pairs, trial.pose, estimator);
    const double trial_error = total_error(trial_system, trial.unmatched, options_, estimator);
    if (!(trial_error < error)) {
      lambda *= 10.0;
      continue;
    }
    const bool settled = error - trial_error <= options_.relative_gain * error;
    trial.iterations = run.iterations + 1;
    run.pose = trial.pose;
    run.pairs = std::move(trial.pairs);
    run.partners = std::move(trial.partners);
    run.unmatched = trial.unmatched;
    run.iterations = trial.iterations;
    system = trial_system;
    error = trial_error;
    lambda = std::max(1e-12, lambda / 10.0);
    ++accepted;
    if (settled) {
      run.status = MatchStatus::converged;
      return;
    }
  }
}

void NlmMatcher::judge(const Run& run, const Estimator& estimator, MatchResult& result) const {
  const Eigen::Matrix2d rotation = run.pose.rotation();
  const double w0 = estimator.weight(0.0);
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  double weights = 0.0, squares = 0.0;
  int near = 0;
  for (std::size_t i = 0; i < run.pairs.size(); ++i) {
    const Eigen::Vector2d turned = rotation * run.pairs[i].source;
    const Eigen::Vector2d e = turned + run.pose.translation_m() - run.pairs[i].target;
    near += e.norm() <= options_.overlap_distance_m;
    const auto count = [&](const Eigen::Vector2d& direction) {
      const double r = direction.dot(e), w = estimator.weight(r) / w0;
      const Eigen::Vector3d j(direction.x(), direction.y(),
                              direction.y() * turned.x() - direction.x() * turned.y());
      normal_matrix += w * j * j.transpose();
      weights += w;
      squares += w * r * r;
    };
    const CalculatedPoints& lines = run.target.lines();
    if (const Line* course = lines.course(run.partners[i])) {
      count(course->normal());
    } else if (lines.embedded(run.partners[i])) {
      count(Eigen::Vector2d::UnitX());
      count(Eigen::Vector2d::UnitY());
    }
  }
  result.iterations = run.iterations;
  result.overlap = static_cast<double>(near) / static_cast<double>(run.source.cols());
  if (near < 2 || result.overlap < options_.min_overlap) return;
  result.status = run.status;
  result.target_from_source = run.pose;
  const double variance = squares / std::max(1.0, weights - 3.0);
  result.rms_m = std::sqrt(squares / std::max(1e-9, weights));
  set_uncertainty(normal_matrix, std::max(variance, options_.noise_m * options_.noise_m), result);
}

MatchResult NlmMatcher::match(const NlmTarget& target,
                              const Points2& source_points,
                              const Pose2& target_from_source_guess) const {
  require(is_finite(target_from_source_guess), "nlm_matcher: the guess is not finite");
  MatchResult result;
  result.target_from_source = target_from_source_guess;
  if (source_points.cols() < 2 || target.index().points().cols() < 2) return result;
  Run run{target, source_points, target_from_source_guess, {}, {}};
  Estimator estimator{kind_, options_.sigma_schedule_m.back()};
  for (const double sigma_m : options_.sigma_schedule_m) {
    estimator.sigma_m = sigma_m;
    descend(run, estimator);
    if (run.pairs.empty() || kind_ == EstimatorKind::least_squares) break;
  }
  judge(run, estimator, result);
  return result;
}

}  // namespace marco::slam
