#include "mapping3d/surface/welded.hpp"

#include <meshoptimizer.h>

namespace marco::mapping3d {
namespace {

// The library compares bytes, and zero has two.
std::vector<Eigen::Vector3f> with_one_zero(std::vector<Eigen::Vector3f> points_m) {
  for (Eigen::Vector3f& point : points_m) point.array() += 0.0F;
  return points_m;
}

}  // namespace

std::optional<TriangleMesh> welded(const TriangleMesh& mesh) {
  const std::vector<Eigen::Vector3f> at_m = with_one_zero(mesh.vertices_m);
  std::vector<unsigned int> number(at_m.size());
  const std::size_t count = meshopt_generateVertexRemap(
      number.data(), nullptr, number.size(), at_m.data(), at_m.size(), sizeof(Eigen::Vector3f));
  if (count == at_m.size()) return std::nullopt;
  TriangleMesh one;
  one.vertices_m.resize(count);
  if (!mesh.colors_rgb.empty()) one.colors_rgb.resize(count);
  if (!mesh.normals.empty()) one.normals.assign(count, Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < number.size(); ++i) {
    one.vertices_m[number[i]] = at_m[i];
    if (!mesh.colors_rgb.empty()) one.colors_rgb[number[i]] = mesh.colors_rgb[i];
    if (!mesh.normals.empty()) one.normals[number[i]] += mesh.normals[i];
  }
  for (Eigen::Vector3f& normal : one.normals) normal.normalize();
  one.triangles.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    one.triangles.push_back({number[a], number[b], number[c]});
  }
  return one;
}

std::vector<std::array<uint32_t, 3>> welded(const std::vector<std::array<uint32_t, 3>>& triangles,
                                            const std::vector<Eigen::Vector3f>& vertices_m) {
  std::vector<std::array<uint32_t, 3>> one(triangles.size());
  if (one.empty()) return one;
  const std::vector<Eigen::Vector3f> at_m = with_one_zero(vertices_m);
  meshopt_generateShadowIndexBuffer(one.front().data(), triangles.front().data(), 3 * one.size(),
                                    at_m.data(), at_m.size(), sizeof(Eigen::Vector3f),
                                    sizeof(Eigen::Vector3f));
  return one;
}

}  // namespace marco::mapping3d
