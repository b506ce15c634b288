#pragma once

#include <limits>
#include <vector>

#include "mapping3d/surface/surface_model.hpp"

namespace marco::mapping3d {

/// Extracts the zero surface by surface nets (Gibson, MICCAI 1998): a vertex in each cell that the
/// surface crosses, at the mean of its crossings, and a quad for each lattice edge that it crosses.
/// Unlike marching cubes a cell does not need all eight samples, so that a band of one voxel is
/// enough and the surface ends at unknown space.
class SurfaceNets {
 public:
  /// @param model  must outlive this object; run() takes its voxels
  explicit SurfaceNets(SurfaceModel& model) : model_(model) {}
  TriangleMesh run();

 private:
  struct Sample {
    float distance = std::numeric_limits<float>::quiet_NaN();  ///< in voxels; NaN = unknown
    uint32_t vertex = 0;  ///< of the cell that begins here, + 1; 0 = none
    PackedNormal facing;
    bool of_both_sides = false;
  };
  using Samples = VoxelBlocks<Sample>;

  void take_samples();
  void set_free(const Cell& cell);
  void cross_block(const Samples::Block& block);
  void cross(const Cell& cell, int axis, float from, float to);
  bool seen_from(const Cell& cell, int axis, bool outwards) const;
  uint32_t vertex(const Cell& cell, const Eigen::Vector3f& crossing);
  void add_quad(std::array<uint32_t, 4> corners, bool flipped);
  void finish_vertices();
  void drop_islands();

  SurfaceModel& model_;
  Samples samples_;
  std::vector<float> crossings_;  ///< of each vertex
  std::vector<std::array<uint32_t, 4>> quads_;
  TriangleMesh mesh_;
};

}  // namespace marco::mapping3d
