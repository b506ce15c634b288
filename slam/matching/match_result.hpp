#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace marco::slam {

enum class MatchStatus {
  converged,        ///< the pose stopped moving
  iteration_limit,  ///< still moving when the iterations ended; the pose is the best so far
  no_overlap        ///< too few points found a partner; the pose is the guess and says nothing
};

/// Answer of a fine matcher.
struct MatchResult {
  MatchStatus status = MatchStatus::no_overlap;
  Pose2 target_from_source;
  /// Of (x [m], y [m], theta [rad]), about target_from_source, x and y in the target's axes.
  /// Directions nothing was seen in (along a bare corridor) have 10 m or π; never NaN.
  Eigen::Matrix3d covariance = Eigen::Vector3d(100.0, 100.0, 9.8696).asDiagonal();
  Eigen::Matrix3d information = Eigen::Vector3d(0.01, 0.01, 0.10132).asDiagonal();  ///< inverse
  double overlap = 0.0;  ///< part of the source points with a partner, 0..1
  double rms_m = 0.0;    ///< of the residuals, weighted by the estimator
  int iterations = 0;
};

/// Fills covariance and information of `result`. @param normal_matrix sum over the points of
/// w n nᵀ in (x, y, theta), w <= 1, @param variance_m2 of one residual. A weak
/// information of (10 m)⁻² and (π rad)⁻² is added, which keeps unseen directions finite.
void set_uncertainty(const Eigen::Matrix3d& normal_matrix, double variance_m2, MatchResult& result);

}  // namespace marco::slam
