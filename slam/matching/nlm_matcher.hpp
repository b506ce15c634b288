#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/matching/calculated_points.hpp"
#include "slam/matching/estimator.hpp"
#include "slam/matching/match_result.hpp"
#include "slam/matching/point_index.hpp"

namespace marco::slam {

struct NlmOptions {
  std::string estimator = "lorentzian";  ///< or least_squares, geman_mcclure
  /// One run per value [m], each started where the one before ended (ch. 5.2: 2, 5, 0.5 without a
  /// unit). With a unit of 4 cm they work for odometry errors of 10 cm and 5 deg; with 10 cm
  /// outliers have more influence.
  std::vector<double> sigma_schedule_m = {0.08, 0.2, 0.02};
  bool calculated_points = true;  ///< match against lines where they fit (ch. 3.4.3)
  CalculatedPointsOptions lines;
  double max_pair_m = 2.0;          ///< largest distance of a correspondence
  double overlap_distance_m = 0.2;  ///< a correspondence within this counts as overlap
  double min_overlap = 0.2;         ///< with less the result is no_overlap
  double noise_m = 0.005;           ///< least standard deviation of a residual, for the covariance
  double lambda_start = 1e-3;       ///< of the damping (3.4.2)
  double lambda_max = 1e8;          ///< a run converges when no step below it lowers the error
  double relative_gain = 1e-7;      ///< a run also converges when a step gains less
  int max_iterations = 50;          ///< accepted steps per run

  template <class Visitor>
  void visit(Visitor& v) {
    v("estimator", estimator);
    v("sigma_schedule_m", sigma_schedule_m, kPositive);
    v("calculated_points", calculated_points);
    v("lines", lines);
    v("max_pair_m", max_pair_m, kPositive);
    v("overlap_distance_m", overlap_distance_m, kPositive);
    v("min_overlap", min_overlap, Limits{0.0, 1.0});
    v("noise_m", noise_m, kPositive);
    v("lambda_start", lambda_start, kPositive);
    v("lambda_max", lambda_max, kPositive);
    v("relative_gain", relative_gain, kNotNegative);
    v("max_iterations", max_iterations, Limits{1, 100000});
  }
};

/// A correspondence [m].
struct PointPair {
  Eigen::Vector2d source;
  Eigen::Vector2d target;
};

/// The error E of a pose Φ = (theta, tx, ty) over fixed pairs and its exact derivatives.
struct NlmSystem {
  double error = 0.0;                                  ///< (3.5)
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< in (theta, tx, ty)
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();   ///< full, with second derivatives
  Eigen::Vector3d damping = Eigen::Vector3d::Zero();   ///< diagonal of the reweighted normal
                                                       ///< matrix: positive where H's may not be
};

/// Thesis B eq. (3.5), (3.9) and app. F, the factor 2 kept. Residuals are x' - x, y' - y.
NlmSystem nlm_system(const std::vector<PointPair>& pairs,
                     const Pose2& target_from_source,
                     const Estimator& estimator);

/// A scan as the target of matches: search index and lines.
class NlmTarget {
 public:
  /// @param points 2×N [m] in sweep order (several scans one after the other are fine), finite.
  explicit NlmTarget(const Points2& points, const CalculatedPointsOptions& lines = {})
      : index_(points), lines_(points, lines) {}
  const PointIndex& index() const { return index_; }
  const CalculatedPoints& lines() const { return lines_; }

 private:
  PointIndex index_;
  CalculatedPoints lines_;
};

/// Scan matching (ICP) by thesis B's Newton-Levenberg-Marquardt (ch. 3.4, app. F): full Hessian,
/// data association at each trial pose, runs over a schedule of sigmas. What differs: the minus
/// sign of step 3 is there; lambda damps diag, not I, since radians and metres mix; lambda also
/// grows while A + lambda diag is not positive definite, as happens far from the optimum; a point
/// without a correspondence costs as much as one at `max_pair_m`, so that losing points never
/// lowers the error. Const, safe from several threads.
class NlmMatcher {
 public:
  /// @throws std::invalid_argument for options outside their limits or an empty schedule.
  explicit NlmMatcher(NlmOptions options = {});

  /// @param source_points 2×N [m], any N, any order, finite. @returns `no_overlap` for 0 or 1
  /// points and for too few correspondences. A correspondence on a line adds information only
  /// across the line, so the covariance grows along a corridor.
  MatchResult match(const NlmTarget& target,
                    const Points2& source_points,
                    const Pose2& target_from_source_guess) const;

  const NlmOptions& options() const { return options_; }

 private:
  struct Run;
  void descend(Run& run, const Estimator& estimator) const;
  void judge(const Run& run, const Estimator& estimator, MatchResult& result) const;

  NlmOptions options_;
  EstimatorKind kind_;
};

}  // namespace marco::slam
