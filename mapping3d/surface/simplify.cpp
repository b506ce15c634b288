#include "mapping3d/surface/simplify.hpp"

#include <meshoptimizer.h>

#include <algorithm>
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

}  // namespace

Simplified simplify(const TriangleMesh& mesh, const SimplifyOptions& options) {
  validate(options, "simplify");
  Simplified result;
  result.mesh = mesh;
  if (mesh.triangles.empty()) return result;
  const std::vector<unsigned int> indices = flat_indices(mesh);
  const float* positions = mesh.vertices_m.front().data();
  const std::size_t stride = sizeof(Eigen::Vector3f);
  const float extent_m = meshopt_simplifyScale(positions, mesh.vertices_m.size(), stride);
  if (!(extent_m > 0.0F)) return result;
  const auto limit_m = static_cast<float>(options.max_error_m);
  const MeshDistance to_mesh(mesh, 2.0F * limit_m);
  float bound_m = 0.7F * limit_m;
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<unsigned int> left(indices.size());
    left.resize(meshopt_simplify(left.data(), indices.data(), indices.size(), positions,
                                 mesh.vertices_m.size(), stride, 0, bound_m / extent_m, 0,
                                 nullptr));
    TriangleMesh fewer = compact(mesh, left);
    const auto area = static_cast<float>(options.sample_m2);
    const double there_m = gap(mesh, MeshDistance(fewer, 2.0F * limit_m), area).max_m;
    const double back_m = gap(fewer, to_mesh, area).max_m;
    const double worst_m = std::max(there_m, back_m);
    if (worst_m <= options.max_error_m) {
      result = {Simplified::Status::within_bound, std::move(fewer), there_m, back_m};
      return result;
    }
    bound_m *= static_cast<float>(std::clamp(options.max_error_m / worst_m, 0.4, 0.8));
  }
  return result;
}

}  // namespace marco::mapping3d
