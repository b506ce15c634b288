#pragma once

#include <vector>

#include "common/options.hpp"
#include "common/pose3.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// A flat patch of a scene: some neighbouring beams and the plane through them.
struct Surfel {
  Eigen::Vector3d center_m;  ///< mean of its points
  Eigen::Vector3d normal;    ///< unit, towards the sensor
};

struct SurfelOptions {
  int block_cells = 4;              ///< a patch is so many rows by so many columns
  double min_filled = 0.7;          ///< part of its beams that must have returned
  double max_thickness_m = 0.03;    ///< rms distance from the plane; more is an edge or clutter
  double max_half_length_m = 0.35;  ///< rms length along the plane; more is too oblique to be sure

  template <class Visitor>
  void visit(Visitor& v) {
    v("block_cells", block_cells, Limits{2, 64});
    v("min_filled", min_filled, Limits{0.1, 1.0});
    v("max_thickness_m", max_thickness_m, kPositive);
    v("max_half_length_m", max_half_length_m, kPositive);
  }
};

/// The patches of a scene by its own grid, frame of `scene`. One pass, O(points).
std::vector<Surfel> find_surfels(const ScenePoints& scene, const SurfelOptions& options = {});

struct RegistrationOptions {
  SurfelOptions surfels;
  double search_start_m = 0.8;    ///< a partner lies nearer, at first ...
  double search_end_m = 0.15;     ///< ... and in the end
  double lorentz_start_m = 0.15;  ///< scale of the Lorentzian at first ...
  double lorentz_end_m = 0.015;   ///< ... and in the end: a few sigma of a patch
  double shrink = 0.65;           ///< of both per iteration
  double max_normal_deg = 45.0;   ///< partners' normals differ less
  double converged_m = 2e-5;      ///< the last step was shorter (at 1 m for turns)
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
    v("converged_m", converged_m, kPositive);
    v("max_iterations", max_iterations, Limits{1, 1000});
    v("min_pairs", min_pairs, Limits{6, 1000000});
  }
};

struct RegistrationResult {
  /// One a scene: today's frame from the frame its points were given in. The first stays where it
  /// is, and so does a scene that no chain of overlaps joins to the first.
  std::vector<Pose3> world_from_placed;
  std::vector<bool> joined;  ///< one a scene; the first is
  bool converged = false;    ///< the steps became small before max_iterations
  int iterations = 0;
  std::size_t pairs = 0;           ///< patches with a partner, in the last iteration
  double median_residual_m = 0.0;  ///< of |point to plane| over those pairs
};

/// Moves scenes onto each other, all overlapping pairs at once: Gauss-Newton on the distances of
/// patch centres from their partners' planes (the mean of both normals, as in Rusinkiewicz, "A
/// symmetric objective function for ICP", 2019, eq. 9 without his split rotation), weighted by the
/// Lorentzian rho(r) = log(1 + r^2 / (2 s^2)), w = 1 / (1 + r^2 / (2 s^2)) (thesis B eq. 3.8's
/// estimator), s and the search radius shrinking. Good from about 0.3 m and 3 deg apart.
/// Directions that the patches do not hold (along a bare corridor) stay where the guess put them.
/// @param placed  each scene by the best guess, one common frame
/// Cost per iteration O(S log S) a pair of scenes with S patches.
RegistrationResult register_scenes(const std::vector<ScenePoints>& placed,
                                   const RegistrationOptions& options = {});

}  // namespace marco::mapping3d
