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
                                 .search_start_m = 0.8,
                                 .search_end_m = 0.15,
                                 .lorentz_start_m = 0.15,
                                 .lorentz_end_m = 0.015,  // or less where surfels fit better
                                 .shrink = 0.6,
                                 .max_normal_deg = 45.0,
                                 .thin_m = 0.003};
  double min_hold = 0.005;  ///< a shift is observable when the mean square of the normals along it
                            ///< reaches this
  double converged_m = 2e-5;  ///< length of the last step (turns at 1 m)
  double settled_m = 3e-4;    ///< the same after ten steps with the narrowest search
  int max_iterations = 40;
  int min_pairs = 60;  ///< with fewer correspondences two scenes do not overlap

  template <class Visitor>
  void visit(Visitor& v) {
    matching.visit(v);
    v("min_hold", min_hold, Limits{0.0, 0.3});
    v("converged_m", converged_m, kPositive);
    v("settled_m", settled_m, kPositive);
    v("max_iterations", max_iterations, Limits{1, 1000});
    v("min_pairs", min_pairs, Limits{6, 1000000});
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
    nothing_to_join,  ///< fewer than two scenes, or no two overlap
    converged,        ///< the steps became small before max_iterations
    not_converged     ///< the poses are the last ones; compare `before` and `after`
  };
  Status status = Status::nothing_to_join;
  /// One a scene: maps its given points to the registered frame. Identity for the first scene and
  /// for those that no chain of overlaps connects to it.
  std::vector<Pose3> world_from_placed;
  std::vector<bool> joined;  ///< one a scene: connected to the first (which is)
  int iterations = 0;
  std::size_t overlaps = 0;  ///< pairs of scenes with correspondences in the last iteration
  PatchResiduals before;     ///< within search_end_m, of a sample of the surfels
  PatchResiduals after;
};

/// e.g. "not converged"
std::string to_string(RegistrationResult::Status status);

/// Multi-view registration (point-to-plane ICP) of scenes: all overlapping pairs at once by
/// Gauss-Newton on the distances of surfel centres from their correspondences' planes (the mean of
/// both normals, as in Rusinkiewicz, "A symmetric objective function for ICP", 2019, eq. 9 without
/// his split rotation). Residuals are weighted by flatness and by a robust kernel, the Lorentzian
/// of thesis B eq. 3.8. The search radius and the kernel's scale shrink, the scale finally to twice
/// the median residual. Converges from about 0.3 m and 3 deg. A shift that a pair's normals do not
/// constrain (along a bare corridor) keeps its initial value.
/// @param placed   each scene by the initial guess, one common frame
/// @param body_of  scenes of one body move together, such as the sweeps of a robot standing still:
/// one index a scene, counted from 0 in order of appearance; empty = each scene is a body
/// @throws std::invalid_argument for other indices
/// Cost per iteration O(S log S) a pair of scenes with S surfels.
RegistrationResult register_scenes(const std::vector<ScenePoints>& placed,
                                   const RegistrationOptions& options = {},
                                   const std::vector<std::size_t>& body_of = {});

}  // namespace marco::mapping3d
