#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/triangle_mesh.hpp"
#include "mapping3d/surface/planes.hpp"

namespace marco::mapping3d {

/// Numbers of the planes that a vertex lies on: three at most, a room's corner.
struct VertexPlanes {
  static constexpr uint32_t kNone = ~0U;
  std::array<uint32_t, 3> numbers{kNone, kNone, kNone};

  std::size_t count() const;
  /// Whether all planes of this vertex are among the other's.
  bool are_all_of(const VertexPlanes& other) const;
  /// Only those that are the other's, too.
  void keep(const VertexPlanes& other);
};

struct LaidOnPlanes {
  std::vector<Eigen::Vector3f> vertices_m;
  std::vector<VertexPlanes> planes;  ///< of each vertex
};

/// Moves vertices the shortest way onto the planes near them, near a corner onto two or three at
/// once; none farther than `snap_m`. A vertex belongs to a plane that it faces as, within its
/// extent and as much around it. Without normals none is moved.
LaidOnPlanes laid_on_planes(const TriangleMesh& mesh,
                            const std::vector<SurfacePlane>& planes,
                            double snap_m);

}  // namespace marco::mapping3d
