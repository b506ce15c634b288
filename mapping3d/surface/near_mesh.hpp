#pragma once

#include <cstdint>
#include <vector>

#include "common/triangle_mesh.hpp"
#include "mapping3d/surface/voxel_blocks.hpp"

namespace marco::mapping3d {

/// Whether a point lies within about two voxels of a fused mesh, which has a vertex in each voxel
/// that it passes. Const members are safe from several threads.
class NearMesh {
 public:
  NearMesh(const TriangleMesh& mesh, double voxel_m) : per_m_(static_cast<float>(1.0 / voxel_m)) {
    std::vector<Cell> ball;
    for (int i = 0; i < 125; ++i) {
      const Cell offset(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2);
      if (offset.squaredNorm() <= kReach * kReach) ball.push_back(offset);
    }
    for (const Eigen::Vector3f& vertex_m : mesh.vertices_m) {
      const Cell middle = cell_of(vertex_m);
      for (const Cell& offset : ball) near_.voxel(middle + offset) = 1;
    }
  }
  bool operator()(const Eigen::Vector3f& point_m) const {
    const uint8_t* const voxel = near_.find_voxel(cell_of(point_m));
    return voxel != nullptr && *voxel != 0;
  }

 private:
  static constexpr int kReach = 2;
  Cell cell_of(const Eigen::Vector3f& point_m) const {
    return (point_m * per_m_).array().round().cast<int>();
  }

  float per_m_;
  VoxelBlocks<uint8_t> near_;
};

}  // namespace marco::mapping3d
