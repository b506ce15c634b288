#include "viewer/crease_corners.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace marco::viewer {
namespace {

// A corner's normal that is farther from its face's is of a crease: the cosine of 30 deg.
constexpr float kSmooth = 0.866F;
// Share of the area about a vertex that makes a face of its own; slivers lie as noise has it.
constexpr float kWorthACorner = 0.1F;

/// Twice the area long.
Eigen::Vector3f normal_of(const Geometry& of, std::size_t triangle) {
  const auto at = [&](std::size_t corner) {
    return Eigen::Vector3f(of.vertices[of.indices[3 * triangle + corner]].position_m.data());
  };
  return (at(1) - at(0)).cross(at(2) - at(0));
}

}  // namespace

void split_creases(Geometry& surfaces) {
  std::vector<std::vector<std::size_t>> about(surfaces.vertices.size());
  std::vector<Eigen::Vector3f> normals(surfaces.indices.size() / 3);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    normals[i] = normal_of(surfaces, i);
    for (std::size_t k = 0; k < 3; ++k) about[surfaces.indices[3 * i + k]].push_back(i);
  }
  for (std::size_t i = 0; i < surfaces.indices.size(); ++i) {
    const uint32_t index = surfaces.indices[i];
    const Eigen::Vector3f face = normals[i / 3].normalized();
    const Vertex corner = surfaces.vertices[index];
    const Eigen::Vector3f own = corner.unit_normal();
    if (own.isZero() || std::abs(own.dot(face)) > kSmooth) continue;
    Eigen::Vector3f alike = Eigen::Vector3f::Zero();
    float all = 0.0F;
    for (const std::size_t other : about[index]) {
      all += normals[other].norm();
      if (normals[other].dot(face) > kSmooth * normals[other].norm()) alike += normals[other];
    }
    if (!(alike.norm() > kWorthACorner * all)) continue;
    surfaces.indices[i] = static_cast<uint32_t>(surfaces.vertices.size());
    surfaces.vertices.push_back(corner);
    surfaces.vertices.back().set_normal((own.dot(alike) < 0.0F ? -1.0F : 1.0F) *
                                        alike.normalized());
  }
}

}  // namespace marco::viewer
