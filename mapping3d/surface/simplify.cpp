#include "mapping3d/surface/simplify.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mapping3d/surface/mesh_distance.hpp"

namespace marco::mapping3d {
namespace {

std::vector<unsigned int> flat_indices(const TriangleMesh& mesh) {
  std::vector<unsigned int> indices;
  indices.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    indices.insert(indices.end(), triangle.begin(), triangle.end());
  }
  return indices;
}

// The triangles that are left, with the vertices they use.
TriangleMesh compact(const TriangleMesh& mesh, const std::vector<unsigned int>& indices) {
  constexpr uint32_t kUnused = std::numeric_limits<uint32_t>::max();
  TriangleMesh result;
  std::vector<uint32_t> moved_to(mesh.vertices_m.size(), kUnused);
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    std::array<uint32_t, 3> triangle{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const unsigned int from = indices[i + corner];
      if (moved_to[from] == kUnused) {
        moved_to[from] = static_cast<uint32_t>(result.vertices_m.size());
        result.vertices_m.push_back(mesh.vertices_m[from]);
        if (!mesh.normals.empty()) result.normals.push_back(mesh.normals[from]);
        if (!mesh.colors_rgb.empty()) result.colors_rgb.push_back(mesh.colors_rgb[from]);
      }
      triangle[corner] = moved_to[from];
    }
    result.triangles.push_back(triangle);
  }
  return result;
}

// Of a vertex near the corner of two planes, onto both.
TriangleMesh laid_on_planes(const TriangleMesh& mesh,
                            const std::vector<SurfacePlane>& planes,
                            double snap_m) {
  constexpr double kMinCosine = 0.5;
  TriangleMesh flat = mesh;
  if (mesh.normals.empty()) return flat;
  for (std::size_t i = 0; i < flat.vertices_m.size(); ++i) {
    const Eigen::Vector3d from = mesh.vertices_m[i].cast<double>();
    const Eigen::Vector3d normal = mesh.normals[i].cast<double>();
    Eigen::Vector3d p = from;
    for (const SurfacePlane& plane : planes) {
      const double off_m = plane.normal.dot(p) - plane.offset_m;
      if (std::abs(off_m) > snap_m || plane.normal.dot(normal) < kMinCosine) continue;
      const Eigen::Vector3d d = p - plane.centre_m;
      const Eigen::Vector2d at(plane.along.dot(d), plane.across.dot(d));
      if ((at - plane.low_m).minCoeff() < 0.0 || (plane.high_m - at).minCoeff() < 0.0) continue;
      const Eigen::Vector3d moved = p - off_m * plane.normal;
      if ((moved - from).norm() <= snap_m) p = moved;
    }
    flat.vertices_m[i] = p.cast<float>();
  }
  return flat;
}

}  // namespace

Simplified simplify(const TriangleMesh& mesh,
                    const std::vector<SurfacePlane>& planes,
                    const SimplifyOptions& options) {
  validate(options, "simplify");
  Simplified result;
  if (mesh.triangles.empty()) return result;
  const double snap_m = options.snap_share * options.max_error_m;
  const TriangleMesh flat = laid_on_planes(mesh, planes, snap_m);
  const std::vector<unsigned int> indices = flat_indices(mesh);
  const float* positions = flat.vertices_m.front().data();
  const std::size_t count = flat.vertices_m.size(), stride = sizeof(Eigen::Vector3f);
  const float extent_m = std::max(1e-6F, meshopt_simplifyScale(positions, count, stride));
  const auto reach_m = static_cast<float>(2.0 * options.max_error_m);
  const auto area_m2 = static_cast<float>(options.sample_m2);
  const MeshDistance to_mesh(mesh, reach_m);
  auto bound_m = static_cast<float>(options.max_error_m - snap_m);
  for (int round = 0; round < options.rounds; ++round, bound_m *= 0.5F) {
    std::vector<unsigned int> left(indices.size());
    left.resize(meshopt_simplify(left.data(), indices.data(), indices.size(), positions, count,
                                 stride, 0, bound_m / extent_m, 0, nullptr));
    result.mesh = compact(flat, left);
    const MeshGap there =
        gap(mesh, MeshDistance(result.mesh, reach_m), area_m2, options.max_error_m);
    const MeshGap back = gap(result.mesh, to_mesh, area_m2, options.max_error_m);
    result.there_m = there.max_m;
    result.back_m = back.max_m;
    result.beyond = std::max(there.beyond, back.beyond);
    const bool within = result.beyond <= options.allowed_beyond;
    result.status = within ? Simplified::Status::within_bound : Simplified::Status::beyond_bound;
    if (within) break;
  }
  return result;
}

}  // namespace marco::mapping3d
