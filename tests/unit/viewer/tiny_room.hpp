#pragma once

#include <cmath>
#include <memory>
#include <random>

#include "viewer/scene.hpp"

namespace marco::viewer::testing {

/// Adds a rectangle as a net of triangles, facing `along` x `across`.
inline void add_face(TriangleMesh& mesh,
                     const Eigen::Vector3f& corner,
                     const Eigen::Vector3f& along,
                     const Eigen::Vector3f& across,
                     float mesh_width_m) {
  const int columns = std::max(1, static_cast<int>(std::lround(along.norm() / mesh_width_m)));
  const int rows = std::max(1, static_cast<int>(std::lround(across.norm() / mesh_width_m)));
  const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
  for (int row = 0; row <= rows; ++row)
    for (int column = 0; column <= columns; ++column)
      mesh.vertices_m.push_back(corner +
                                along * (static_cast<float>(column) / static_cast<float>(columns)) +
                                across * (static_cast<float>(row) / static_cast<float>(rows)));
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const uint32_t a = first + static_cast<uint32_t>(row * (columns + 1) + column);
      const uint32_t b = a + 1, c = a + static_cast<uint32_t>(columns) + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
}

/// Five outer faces of a box that stands on the floor.
inline void add_furniture(TriangleMesh& mesh,
                          const Eigen::Vector3f& low,
                          const Eigen::Vector3f& size,
                          float mesh_width_m) {
  using Eigen::Vector3f;
  const Vector3f x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
  add_face(mesh, low + z, x, y, mesh_width_m);
  add_face(mesh, low, x, z, mesh_width_m);
  add_face(mesh, low + y, z, x, mesh_width_m);
  add_face(mesh, low, z, y, mesh_width_m);
  add_face(mesh, low + x, y, z, mesh_width_m);
}

/// A room seen from inside: x 0..6, y 0..4, z 0..2.5 m, a table (x 2..3.4, y 1.4..2.2, z 0.75 m)
/// and a cupboard (x 5.4..6, y 0..1.2, z 1.8 m).
inline TriangleMesh make_room(float mesh_width_m = 0.5F, float noise_sigma_m = 0.0F) {
  using Eigen::Vector3f;
  const Vector3f x(6, 0, 0), y(0, 4, 0), z(0, 0, 2.5F), origin(0, 0, 0);
  TriangleMesh mesh;
  add_face(mesh, origin, x, y, mesh_width_m);
  add_face(mesh, z, y, x, mesh_width_m);
  add_face(mesh, origin, z, x, mesh_width_m);
  add_face(mesh, y, x, z, mesh_width_m);
  add_face(mesh, origin, y, z, mesh_width_m);
  add_face(mesh, x, z, y, mesh_width_m);
  add_furniture(mesh, {2.0F, 1.4F, 0}, {1.4F, 0.8F, 0.75F}, mesh_width_m);
  add_furniture(mesh, {5.4F, 0.0F, 0}, {0.6F, 1.2F, 1.8F}, mesh_width_m);
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0.0F, 1.0F);
  if (noise_sigma_m > 0.0F)
    for (Vector3f& vertex : mesh.vertices_m)
      vertex += noise_sigma_m * Vector3f(noise(random), noise(random), noise(random));
  return mesh;
}

inline Scene room_scene(float mesh_width_m = 0.5F, float noise_sigma_m = 0.0F) {
  Scene scene;
  scene.meshes.push_back(
      {std::make_shared<const TriangleMesh>(make_room(mesh_width_m, noise_sigma_m))});
  return scene;
}

}  // namespace marco::viewer::testing
