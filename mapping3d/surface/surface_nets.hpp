#pragma once

#include <vector>

#include "mapping3d/surface/surface_model.hpp"

namespace marco::mapping3d {

/// Extracts the zero surface by surface nets (Gibson, MICCAI 1998): a vertex in each cell that the
/// surface crosses, at the mean of its crossings, and a quad for each lattice edge that it crosses.
/// Unlike marching cubes a cell does not need all eight samples, so that a band of one voxel is
/// enough and the surface ends at unknown space.
class SurfaceNets {
 public:
  /// @param model must outlive this object.
  explicit SurfaceNets(const SurfaceModel& model) : model_(model) {}
  TriangleMesh run();

 private:
  using Samples = VoxelBlocks<float>;  ///< distances in voxels, NaN = unknown

  void take_samples();
  void set_free(const Cell& cell);
  void cross_block(const Samples::Block& block);
  void cross(const Cell& cell, int axis, float from, float to);
  bool seen_from(const Cell& cell, int axis, bool outwards) const;
  uint32_t vertex(const Cell& cell, const Eigen::Vector3f& crossing);
  void add_quad(std::array<uint32_t, 4> corners, bool flipped);
  void finish_vertices();
  void drop_islands();

  const SurfaceModel& model_;
  Samples samples_;
  VoxelBlocks<uint32_t> vertex_of_;  ///< of a cell, + 1; 0 = none
  std::vector<float> crossings_;     ///< of each vertex
  std::vector<std::array<uint32_t, 4>> quads_;
  TriangleMesh mesh_;
};

}  // namespace marco::mapping3d
