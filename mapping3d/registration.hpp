#pragma once

#include <string>
#include <vector>

#include "common/pose3.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/surfel_matching.hpp"

namespace marco::mapping3d {

struct RegistrationOptions {
  SurfelMatchingOptions matching{.surfels = {},
                                 .search_start_m = 0.3,
                                 .search_end_m = 0.15,
                                 .lorentz_start_m = 0.1,
                                 .lorentz_end_m = 0.015,  // or less where surfels fit better
                                 .shrink = 0.6,
                                 .max_normal_deg = 45.0,
                                 .thin_m = 0.003};
  double path_sigma_m = 0.1;     ///< of a stop's place by the path, in the plane
  double path_sigma_deg = 1.0;   ///< of its heading
  double floor_sigma_m = 0.02;   ///< of the floor's height: a wheeled robot stays on it
  double floor_sigma_deg = 0.5;  ///< of the floor's slope
  int max_iterations = 40;
  int min_pairs = 60;  ///< with fewer correspondences two stops do not overlap

  template <class Visitor>
  void visit(Visitor& v) {
    matching.visit(v);
    v.advanced("path_sigma_m", path_sigma_m, kPositive,
               "Standard deviation of a stop's place by the 2D path. More for poor odometry.");
    v.advanced("floor_sigma_m", floor_sigma_m, kPositive,
               "Standard deviation of the floor's height between stops. More for ramps.");
    v.advanced("floor_sigma_deg", floor_sigma_deg, kPositive,
               "Standard deviation of the floor's slope. More for ramps.");
    v.advanced("min_pairs", min_pairs, Limits{6, 1000000},
               "Two stops with fewer correspondences do not overlap.");
  }
};

/// |point to plane| over the correspondences [m].
struct PatchResiduals {
  std::size_t count = 0;
  double median_m = 0.0;
  double p90_m = 0.0;
};

struct RegistrationResult {
  enum class Status {
    nothing_to_join,  ///< fewer than two bodies, or no two overlap
    converged,        ///< the steps became small before max_iterations
    not_converged     ///< the poses are those of the path
  };
  Status status = Status::nothing_to_join;
  /// One a scene: maps its given points to the registered frame. Identity for scenes that overlap
  /// no other one, and for bodies that were refused.
  std::vector<Pose3> world_from_placed;
  std::vector<bool> joined;  ///< one a scene: placed by what it sees in common with others
  int iterations = 0;
  std::size_t overlaps = 0;  ///< pairs of bodies with correspondences in the last iteration
  std::size_t refused = 0;   ///< bodies left where the path has them, though others overlap them
  PatchResiduals before;     ///< within search_end_m, of a sample of the surfels
  PatchResiduals after;
};

/// e.g. "not converged"
std::string to_string(RegistrationResult::Status status);

/// Multi-view registration (point-to-plane ICP) of scenes: all overlapping pairs at once by
/// Gauss-Newton on the distances of surfel centres from their correspondences' planes (the mean of
/// both normals, as in Rusinkiewicz, "A symmetric objective function for ICP", 2019, eq. 9 without
/// his split rotation), with the path as a prior of each body: what surfaces do not constrain
/// (along a bare corridor, the height of a room seen through a door) stays as it was. Residuals are
/// weighted by flatness and by a robust kernel, the Lorentzian of thesis B eq. 3.8. The search
/// radius and the kernel's scale shrink, the scale finally to twice the median residual. Converges
/// from about 0.3 m and 3 deg. A body whose correction contradicts the path stays
/// there; the others are then solved without it.
/// @param placed   each scene by the initial guess, one common frame
/// @param body_of  scenes of one body move together, such as the sweeps of a robot standing still:
/// one index a scene, counted from 0 in order of appearance; empty = each scene is a body
/// @throws std::invalid_argument for other indices
/// Cost per iteration O(S log S) a pair of overlapping bodies with S surfels; a body has at most
/// eight or so.
RegistrationResult register_scenes(const PlacedScenes& placed,
                                   const RegistrationOptions& options = {},
                                   const std::vector<std::size_t>& body_of = {});
inline RegistrationResult register_scenes(const std::vector<ScenePoints>& placed,
                                          const RegistrationOptions& options = {},
                                          const std::vector<std::size_t>& body_of = {}) {
  return register_scenes(PlacedScenes::of(placed), options, body_of);
}

}  // namespace marco::mapping3d
