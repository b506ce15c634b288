#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace marco::slam {

enum class MatchStatus {
  converged,
  iteration_limit,  ///< not converged; the pose is the best so far
  no_overlap        ///< too few correspondences; the pose is the guess
};

/// Result of a scan match.
struct MatchResult {
  MatchStatus status = MatchStatus::no_overlap;
  Pose2 target_from_source;
  /// Of (x [m], y [m], theta [rad]) of target_from_source, in the target's axes. Unobservable
  /// directions (along a bare corridor) have 10 m or π; never NaN.
  Eigen::Matrix3d covariance = Eigen::Vector3d(100.0, 100.0, 9.8696).asDiagonal();
  Eigen::Matrix3d information = Eigen::Vector3d(0.01, 0.01, 0.10132).asDiagonal();  ///< inverse
  double overlap = 0.0;  ///< part of the source points with a correspondence, 0..1
  double rms_m = 0.0;    ///< of the residuals, weighted by the robust kernel
  int iterations = 0;
};

/// Fills the covariance and the information matrix of `result`. A weak prior of (10 m)⁻² and
/// (π rad)⁻² keeps unobservable directions finite.
/// @param normal_matrix  sum over the points of w n nᵀ in (x, y, theta), w <= 1
/// @param variance_m2    of one residual
void set_uncertainty(const Eigen::Matrix3d& normal_matrix, double variance_m2, MatchResult& result);

}  // namespace marco::slam
