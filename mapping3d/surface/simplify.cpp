#include "mapping3d/surface/simplify.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mesh_samples.hpp"
#include "mapping3d/scene_mesh.hpp"
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

// The given triangles with the vertices that they use.
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

// Snaps vertices to planes; near the corner of two planes to both.
TriangleMesh laid_on_planes(const TriangleMesh& mesh,
                            const std::vector<SurfacePlane>& planes,
                            double snap_m) {
  constexpr double kMinCosine =
      0.5;  // a vertex whose normal is off by 60 degrees belongs to another surface
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

TriangleMesh collapsed(const TriangleMesh& mesh, float bound_m) {
  if (mesh.triangles.empty()) return {};
  const std::vector<unsigned int> indices = flat_indices(mesh);
  const float* positions = mesh.vertices_m.front().data();
  const std::size_t count = mesh.vertices_m.size(), stride = sizeof(Eigen::Vector3f);
  const float extent_m = std::max(1e-6F, meshopt_simplifyScale(positions, count, stride));
  std::vector<unsigned int> left(indices.size());
  left.resize(meshopt_simplify(left.data(), indices.data(), indices.size(), positions, count,
                               stride, 0, bound_m / extent_m, 0, nullptr));
  return compact(mesh, left);
}

// Flags the triangles with a sample or corner beyond the limit.
std::vector<uint8_t> beyond(const TriangleMesh& mesh,
                            const MeshDistance& to,
                            float sample_m2,
                            float limit_m) {
  std::vector<uint8_t> corners(mesh.vertices_m.size()), flags(mesh.triangles.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = to(mesh.vertices_m[i]) > limit_m ? 1 : 0;
  }
  for (std::size_t t = 0; t < flags.size(); ++t) {
    for (const uint32_t corner : mesh.triangles[t]) flags[t] |= corners[corner];
  }
  // Slivers have hardly any area to sample, but edges.
  const float step_m = std::sqrt(sample_m2);
  for (std::size_t t = 0; t < flags.size(); ++t) {
    for (std::size_t side = 0; side < 3 && flags[t] == 0; ++side) {
      const Eigen::Vector3f& from = mesh.vertices_m[mesh.triangles[t][side]];
      const Eigen::Vector3f edge = mesh.vertices_m[mesh.triangles[t][(side + 1) % 3]] - from;
      const int steps = static_cast<int>(edge.norm() / step_m);
      for (int i = 1; i < steps && flags[t] == 0; ++i) {
        const float part = static_cast<float>(i) / static_cast<float>(steps);
        if (to(from + part * edge) > limit_m) flags[t] = 1;
      }
    }
  }
  for_each_sample(mesh, sample_m2, [&](const Eigen::Vector3f& point, std::size_t t) {
    if (flags[t] == 0 && to(point) > limit_m) flags[t] = 1;
  });
  return flags;
}

TriangleMesh taken(const TriangleMesh& mesh, const std::vector<uint8_t>& flags, uint8_t wanted) {
  std::vector<unsigned int> indices;
  for (std::size_t t = 0; t < flags.size(); ++t) {
    if (flags[t] != wanted) continue;
    indices.insert(indices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
  }
  return compact(mesh, indices);
}

// Flags also the triangles that share a corner with a flagged one.
std::vector<uint8_t> grown(const TriangleMesh& mesh, const std::vector<uint8_t>& flags) {
  std::vector<uint8_t> touched(mesh.vertices_m.size()), all(flags);
  for (std::size_t t = 0; t < flags.size(); ++t) {
    if (flags[t] == 0) continue;
    for (const uint32_t corner : mesh.triangles[t]) touched[corner] = 1;
  }
  for (std::size_t t = 0; t < flags.size(); ++t) {
    for (const uint32_t corner : mesh.triangles[t]) all[t] |= touched[corner];
  }
  return all;
}

}  // namespace

Simplified simplify(const TriangleMesh& mesh,
                    const std::vector<SurfacePlane>& planes,
                    const SimplifyOptions& options) {
  validate(options, "simplify");
  Simplified result;
  if (mesh.triangles.empty()) return result;
  // The distance may be a little larger between samples.
  constexpr double kBetweenSamples = 0.9;
  const double snap_m = options.snap_share * options.max_error_m;
  const auto limit_m = static_cast<float>(kBetweenSamples * options.max_error_m);
  const auto reach_m = static_cast<float>(2.0 * options.max_error_m);
  const auto area_m2 = static_cast<float>(options.sample_m2);
  const MeshDistance to_mesh(mesh, reach_m);
  auto bound_m = static_cast<float>(options.max_error_m - snap_m);
  TriangleMesh open = mesh;  // what the result does not cover yet
  for (int round = 0; round < options.rounds && !open.triangles.empty(); ++round) {
    const TriangleMesh fewer =
        collapsed(laid_on_planes(open, planes, round == 0 ? snap_m : 0.0), bound_m);
    append_mesh(result.mesh, taken(fewer, beyond(fewer, to_mesh, area_m2, limit_m), 0));
    const MeshDistance to_result(result.mesh, reach_m);
    const std::vector<uint8_t> uncovered = beyond(open, to_result, area_m2, limit_m);
    open = taken(open, grown(open, uncovered), 1);
    bound_m *= 0.5F;
  }
  result.as_it_was = open.triangles.size();
  append_mesh(result.mesh, open);
  const MeshGap there = gap(mesh, MeshDistance(result.mesh, reach_m), area_m2, options.max_error_m);
  const MeshGap back = gap(result.mesh, to_mesh, area_m2, options.max_error_m);
  result.there_m = there.max_m;
  result.back_m = back.max_m;
  result.beyond = std::max(there.beyond, back.beyond);
  result.status =
      result.beyond > 0.0 ? Simplified::Status::beyond_bound : Simplified::Status::within_bound;
  return result;
}

}  // namespace marco::mapping3d
