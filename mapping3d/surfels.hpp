#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "mapping3d/point_tree.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// A flat patch of a scene: some neighbouring beams and the plane through them.
struct Surfel {
  Eigen::Vector3d center_m;  ///< mean of its points
  Eigen::Vector3d normal;    ///< unit, towards the sensor
  double thickness_m;        ///< rms distance of its points from the plane
  std::size_t row;           ///< of the first of its cells in the scene's grid
  std::size_t column;
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

/// The patches of a scene, to be asked for the one nearest to a point. Const: safe from several
/// threads.
struct SurfelIndex {
  explicit SurfelIndex(std::vector<Surfel> of_scene);

  std::vector<Surfel> surfels;
  PointTree centers;
  Eigen::AlignedBox3d box;  ///< of the centres
};

/// Weight of the distance between two patches: the Lorentzian's 1 / (1 + r^2 / (2 s^2)), halved
/// where the patches are `thin_m` thick together.
double pair_weight(const Surfel& a, const Surfel& b, double scaled_residual, double thin_m);

/// The value below which `part` of them lie; reorders them. 0 of none.
double quantile(std::vector<double>& values, double part);

}  // namespace marco::mapping3d
