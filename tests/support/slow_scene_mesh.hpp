#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "mapping3d/scene_mesh.hpp"

namespace marco::testing {

inline constexpr uint32_t kNoVertex = std::numeric_limits<uint32_t>::max();

/// The mesh of a scene quad by quad, edge by edge: what mesh_scene() must equal.
class SlowMesher {
 public:
  explicit SlowMesher(const mapping3d::ScenePoints& scene,
                      const mapping3d::SceneMeshOptions& options = {})
      : scene_(scene),
        options_(options),
        vertex_of_(scene.points_m.size(), kNoVertex),
        spacing_rad_(mapping3d::beam_spacing_rad(scene)) {}

  TriangleMesh run() {
    for (std::size_t row = 0; row + 1 < scene_.rows; ++row) {
      for (std::size_t column = 0; column + 1 < scene_.columns; ++column) {
        const auto at = static_cast<uint32_t>(scene_.index(row, column));
        const auto below = static_cast<uint32_t>(scene_.index(row + 1, column));
        add_quad({at, at + 1, below + 1, below});
      }
    }
    for (Eigen::Vector3f& normal : mesh_.normals) {
      const float length = normal.norm();
      if (length > 0.0F) normal /= length;
    }
    return std::move(mesh_);
  }

 private:
  const Eigen::Vector3f& origin(uint32_t index) const {
    return scene_.origins_m[index / scene_.columns];
  }
  Eigen::Vector3f beam(uint32_t index) const { return scene_.points_m[index] - origin(index); }

  bool joined(uint32_t a, uint32_t b) const {
    const float range_m = std::min(beam(a).norm(), beam(b).norm());
    const float limit_m =
        std::min(static_cast<float>(options_.max_edge_m),
                 std::max(static_cast<float>(options_.edge_floor_m),
                          static_cast<float>(options_.edge_factor) * spacing_rad_ * range_m));
    return (scene_.points_m[a] - scene_.points_m[b]).squaredNorm() <= limit_m * limit_m;
  }

  void add_quad(const std::array<uint32_t, 4>& quad) {
    int valid = 0;
    for (const uint32_t corner : quad) valid += scene_.valid[corner];
    if (valid < 3) return;
    if (valid == 3) {
      std::array<uint32_t, 3> triangle{};
      std::size_t count = 0;
      for (const uint32_t corner : quad) {
        if (scene_.valid[corner] != 0) triangle[count++] = corner;
      }
      add_triangle(triangle);
      return;
    }
    const auto& p = scene_.points_m;
    const bool first_diagonal =
        (p[quad[0]] - p[quad[2]]).squaredNorm() <= (p[quad[1]] - p[quad[3]]).squaredNorm();
    if (first_diagonal) {
      add_triangle({quad[0], quad[1], quad[2]});
      add_triangle({quad[0], quad[2], quad[3]});
    } else {
      add_triangle({quad[0], quad[1], quad[3]});
      add_triangle({quad[1], quad[2], quad[3]});
    }
  }

  void add_triangle(std::array<uint32_t, 3> corners) {
    if (!joined(corners[0], corners[1]) || !joined(corners[1], corners[2]) ||
        !joined(corners[2], corners[0])) {
      return;
    }
    const auto& p = scene_.points_m;
    // Twice the area long: vertices' normals are weighted by it.
    Eigen::Vector3f normal = (p[corners[1]] - p[corners[0]]).cross(p[corners[2]] - p[corners[0]]);
    const float away = normal.dot(beam(corners[0]));
    if (away == 0.0F) return;
    if (away > 0.0F) {
      std::swap(corners[1], corners[2]);
      normal = -normal;
    }
    std::array<uint32_t, 3> triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      triangle[i] = vertex(corners[i]);
      mesh_.normals[triangle[i]] += normal;
    }
    mesh_.triangles.push_back(triangle);
  }

  uint32_t vertex(uint32_t index) {
    if (vertex_of_[index] == kNoVertex) {
      vertex_of_[index] = static_cast<uint32_t>(mesh_.vertices_m.size());
      mesh_.vertices_m.push_back(scene_.points_m[index]);
      mesh_.normals.emplace_back(Eigen::Vector3f::Zero());
    }
    return vertex_of_[index];
  }

  const mapping3d::ScenePoints& scene_;
  mapping3d::SceneMeshOptions options_;
  std::vector<uint32_t> vertex_of_;
  float spacing_rad_;
  TriangleMesh mesh_;
};

}  // namespace marco::testing
