#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "mapping3d/point_tree.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// A surfel: a flat patch of neighbouring beams and the plane through them.
struct Surfel {
  Eigen::Vector3d center_m;  ///< mean of its points
  Eigen::Vector3d normal;    ///< unit, towards the sensor
  double thickness_m;        ///< rms distance of its points from the plane
  std::size_t row;           ///< of its first beam in the scene's grid
  std::size_t column;

  double thickness2_m2() const { return thickness_m * thickness_m; }
};

struct SurfelOptions {
  int block_cells = 4;              ///< rows and columns of beams in a surfel
  double min_filled = 0.7;          ///< part of its beams that must have returned
  double max_thickness_m = 0.03;    ///< rms distance from the plane; more is an edge or clutter
  double max_half_length_m = 0.35;  ///< rms extent along the plane; more is seen too obliquely

  template <class Visitor>
  void visit(Visitor& v) {
    v("block_cells", block_cells, Limits{2, 64});
    v("min_filled", min_filled, Limits{0.1, 1.0});
    v("max_thickness_m", max_thickness_m, kPositive);
    v("max_half_length_m", max_half_length_m, kPositive);
  }
};

/// The surfels of a scene by its own grid, frame of `scene`. One pass, O(points).
std::vector<Surfel> find_surfels(const ScenePoints& scene, const SurfelOptions& options = {});

/// A rectangle of a scene's grid.
struct GridBlock {
  std::size_t row, column;  ///< of its first beam
  std::size_t rows, columns;
};

/// Mean of a block's returns; nothing when no beam returned.
std::optional<Eigen::Vector3d> block_mean(const ScenePoints& scene, const GridBlock& block);

/// The surfels of a scene with a search tree. Const: safe from several threads.
struct SurfelIndex {
  explicit SurfelIndex(std::vector<Surfel> of_scene);

  std::vector<Surfel> surfels;
  PointTree centers;
  Eigen::AlignedBox3d box;  ///< of the centres
};

/// The value below which `part` of them lie, 0 without values. Reorders them.
double quantile(std::vector<double>& values, double part);

}  // namespace marco::mapping3d
