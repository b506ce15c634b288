#pragma once

#include <vector>

#include "common/linear_algebra.hpp"
#include "common/pose3.hpp"
#include "mapping3d/surfels.hpp"

namespace marco::mapping3d {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Scenes that move together, such as the sweeps of a robot that stands still, with the correction
/// of the place that the path gives them.
struct RegistrationBody {
  SurfelIndex surfels;                     ///< of all its scenes, as placed by the path
  Eigen::Vector3d pivot_m;                 ///< the middle of its beams' origins
  Vector6d correction = Vector6d::Zero();  ///< a rotation vector about the pivot, then a shift
  bool refused = false;                    ///< stays on the path

  /// Where its points belong, from where the path places them.
  Pose3 world_from_placed() const;
  /// Maps a twist about the pivot as it lies now to the same one about the world's origin.
  Matrix6d origin_from_pivot() const;
  /// Adds a small twist about the pivot.
  void move(const Vector6d& twist);
};

/// What one pair says about a turn and shift of the second body against the first, about the
/// world's origin.
struct PairSystem : NormalEquations<6> {
  double weight = 0.0;
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< weighted sum, as placed
  std::vector<double> residuals_m;

  /// Keeps the path's relative shift along directions with hardly any normals: these are noise.
  void hold_loose_shifts(const Pose3& world_from_a, const Pose3& world_from_b);
};

/// @param body_of  one index a scene, counted from 0 in order of appearance
/// @throws std::invalid_argument for other indices
std::vector<RegistrationBody> make_bodies(const PlacedScenes& placed,
                                          const std::vector<std::size_t>& body_of,
                                          const SurfelOptions& options);

}  // namespace marco::mapping3d
