#pragma once

#include <Eigen/Core>

#include "slam/matching/correspondences.hpp"

namespace marco::slam {

/// The direction of translation that a match knows least, and how much of what its point-to-line
/// constraints claim there comes from walls. Noise of the normals makes a bare corridor look
/// constrained along itself.
struct WeakestDirection {
  Eigen::Vector2d direction;  ///< unit length, map frame; the heading is marginalized
  double information;         ///< claimed along it, at least 0
  /// The part that no wall gives, at most `information`; the larger one of two estimates. Normals:
  /// kNormalSigma^2 sum w (t . direction)^2, t along the wall. Cost: what the squared distances,
  /// truncated at the kernel's reach, do not show when the scan is moved by that reach along
  /// `direction` to either side and associated anew. The first one alone misses near walls, whose
  /// normals are noisier; the second one alone misses what moves with the robot, as the ends of
  /// walls at the range limit do.
  double by_noise;

  /// @param points  associated with `map`. @param sigma_m  of the kernel, as in
  /// Correspondences::sum.
  WeakestDirection(const SurfelMap& map,
                   const Correspondences& points,
                   const Pose2& centre_from_robot,
                   double sigma_m);

  double honest() const { return information - by_noise; }
  /// Normal equations of the match without by_noise; positive semidefinite.
  Eigen::Matrix3d without_noise() const;

 private:
  Eigen::Matrix3d sum_;
};

}  // namespace marco::slam
