#pragma once

#include <string>
#include <vector>

#include "common/pose3.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/surfels.hpp"

namespace marco::mapping3d {

struct RegistrationOptions {
  SurfelOptions surfels;
  double search_start_m = 0.8;    ///< a partner lies nearer, at first ...
  double search_end_m = 0.15;     ///< ... and in the end
  double lorentz_start_m = 0.15;  ///< scale of the Lorentzian at first ...
  double lorentz_end_m = 0.015;   ///< ... and in the end, or less where patches fit better
  double shrink = 0.6;            ///< of both per iteration
  double max_normal_deg = 45.0;   ///< partners' normals differ less
  double thin_m = 0.003;          ///< a patch this thick counts half as much as a flat one
  double min_hold = 0.005;  ///< a shift is held when the mean square of the normals along it is at
                            ///< least so much
  double converged_m = 2e-5;  ///< the last step was shorter (at 1 m for turns)
  double settled_m = 3e-4;    ///< or, after ten steps at the narrowest search, shorter than this
  int max_iterations = 40;
  int min_pairs = 60;  ///< fewer partners: the two scenes do not overlap

  template <class Visitor>
  void visit(Visitor& v) {
    v("surfels", surfels);
    v("search_start_m", search_start_m, kPositive);
    v("search_end_m", search_end_m, kPositive);
    v("lorentz_start_m", lorentz_start_m, kPositive);
    v("lorentz_end_m", lorentz_end_m, kPositive);
    v("shrink", shrink, Limits{0.1, 0.99});
    v("max_normal_deg", max_normal_deg, Limits{1.0, 90.0});
    v("thin_m", thin_m, kPositive);
    v("min_hold", min_hold, Limits{0.0, 0.3});
    v("converged_m", converged_m, kPositive);
    v("settled_m", settled_m, kPositive);
    v("max_iterations", max_iterations, Limits{1, 1000});
    v("min_pairs", min_pairs, Limits{6, 1000000});
  }
};

/// |point to plane| over patches with a partner [m].
struct PatchResiduals {
  std::size_t count = 0;
  double median_m = 0.0;
  double p90_m = 0.0;
};

struct RegistrationResult {
  enum class Status {
    nothing_to_join,  ///< fewer than two scenes, or no two overlap
    converged,        ///< the steps became small before max_iterations
    not_converged     ///< the poses are the last ones; better than the guess by `after` or not
  };
  Status status = Status::nothing_to_join;
  /// One a scene: today's frame from the frame its points were given in. The first stays where it
  /// is, and so does a scene that no chain of overlaps joins to the first.
  std::vector<Pose3> world_from_placed;
  std::vector<bool> joined;  ///< one a scene; the first is
  int iterations = 0;
  std::size_t overlaps = 0;  ///< pairs of scenes with partners in the last iteration
  PatchResiduals before;     ///< partners within search_end_m, of a sample of the patches
  PatchResiduals after;
};

/// e.g. "not converged"
std::string to_string(RegistrationResult::Status status);

/// Moves scenes onto each other, all overlapping pairs at once: Gauss-Newton on the distances of
/// patch centres from their partners' planes (the mean of both normals, as in Rusinkiewicz, "A
/// symmetric objective function for ICP", 2019, eq. 9 without his split rotation), weighted by the
/// patches' flatness and by the Lorentzian rho(r) = log(1 + r^2 / (2 s^2)),
/// w = 1 / (1 + r^2 / (2 s^2)) (thesis B eq. 3.8's estimator), s and the search radius shrinking,
/// s in the end to twice the median residual. Good from about 0.3 m and 3 deg apart. A shift that
/// the patches of a pair do not hold (along a bare corridor) stays where the guess put it.
/// @param placed  each scene by the best guess, one common frame
/// @param body_of  scenes of one body move as one, as sweeps do that a robot made standing still:
/// one number a scene, counted from 0 as bodies first appear; empty = each scene by itself
/// @throws std::invalid_argument of other numbers
/// Cost per iteration O(S log S) a pair of scenes with S patches.
RegistrationResult register_scenes(const std::vector<ScenePoints>& placed,
                                   const RegistrationOptions& options = {},
                                   const std::vector<std::size_t>& body_of = {});

}  // namespace marco::mapping3d
