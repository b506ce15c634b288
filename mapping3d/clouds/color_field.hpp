#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/triangle_mesh.hpp"
#include "mapping3d/surface/voxel_blocks.hpp"

namespace marco::mapping3d {

/// The colours of points in space: a mean in each cube. Not thread-safe.
class ColorField {
 public:
  /// @param cube_m  edge of a cube: about as far as a surface lies from its points
  explicit ColorField(double cube_m) : cube_m_(static_cast<float>(cube_m)) {}

  void add(const Eigen::Vector3f& point_m, const std::array<uint8_t, 3>& rgb);

  /// Colours a mesh's vertices by the points of their cube, or else of those around it, or else as
  /// the nearest vertices along the surface; grey where there are none.
  void paint(TriangleMesh& mesh) const;

 private:
  struct Sum {
    std::array<float, 3> rgb{};
    float count = 0.0F;
  };
  Cell cell_of(const Eigen::Vector3f& point_m) const;
  Sum around(const Cell& cell) const;

  float cube_m_;
  VoxelBlocks<Sum> sums_;
};

}  // namespace marco::mapping3d
