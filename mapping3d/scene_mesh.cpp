#include "mapping3d/scene_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace marco::mapping3d {
namespace {

class ThesisRule {
 public:
  ThesisRule(const ScenePoints& scene, const ThesisMeshOptions& options)
      : scene_(scene),
        min2_(static_cast<float>(options.min_edge_m * options.min_edge_m)),
        max2_(static_cast<float>(options.max_edge_m * options.max_edge_m)) {
    validate(options, "thesis_mesh");
  }
  template <std::size_t N>
  bool allows(const std::array<uint32_t, N>& polygon) const {
    if (scene_.valid[polygon[0]] == 0) return false;
    for (std::size_t i = 1; i < N; ++i) {
      if (scene_.valid[polygon[i]] == 0) return false;
      const float length2 =
          (scene_.points_m[polygon[i]] - scene_.points_m[polygon[0]]).squaredNorm();
      if (length2 < min2_ || length2 > max2_) return false;
    }
    return true;
  }

 private:
  const ScenePoints& scene_;
  float min2_;
  float max2_;
};

template <class Visit>
void for_each_quad(const ScenePoints& scene, const Visit& visit) {
  for (std::size_t row = 0; row + 1 < scene.rows; ++row) {
    for (std::size_t column = 0; column + 1 < scene.columns; ++column) {
      const auto at = static_cast<uint32_t>(scene.index(row, column));
      const auto below = static_cast<uint32_t>(scene.index(row + 1, column));
      visit(std::array<uint32_t, 4>{at, at + 1, below + 1, below});
    }
  }
}

constexpr uint32_t kNoVertex = std::numeric_limits<uint32_t>::max();

class Mesher {
 public:
  Mesher(const ScenePoints& scene, const SceneMeshOptions& options)
      : scene_(scene), options_(options), vertex_of_(scene.points_m.size(), kNoVertex) {
    validate(options, "scene_mesh");
    find_spacing();
  }

  TriangleMesh run() {
    for_each_quad(scene_, [this](const std::array<uint32_t, 4>& quad) { add_quad(quad); });
    for (Eigen::Vector3f& normal : mesh_.normals) {
      const float length = normal.norm();
      if (length > 0.0F) normal /= length;
    }
    return std::move(mesh_);
  }

 private:
  // Angle between neighbours along a row and from row to row, seen from the sensor: medians would
  // be truer, but every beam of a row has the same step, and so nearly has every row.
  void find_spacing() {
    float sum = 0.0F;
    int count = 0;
    for_each_quad(scene_, [&](const std::array<uint32_t, 4>& quad) {
      if (scene_.valid[quad[0]] == 0 || scene_.valid[quad[2]] == 0) return;
      const Eigen::Vector3f a = beam(quad[0]), b = beam(quad[2]);
      sum += std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0F, 1.0F));
      ++count;
    });
    spacing_rad_ = count > 0 ? sum / static_cast<float>(count) : 0.0F;
  }
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
    if (!(normal.squaredNorm() > 0.0F)) return;
    if (normal.dot(beam(corners[0])) > 0.0F) {
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

  const ScenePoints& scene_;
  SceneMeshOptions options_;
  std::vector<uint32_t> vertex_of_;
  float spacing_rad_ = 0.0F;
  TriangleMesh mesh_;
};

}  // namespace

std::vector<std::array<uint32_t, 4>> thesis_quads(const ScenePoints& scene,
                                                  const ThesisMeshOptions& options) {
  const ThesisRule rule(scene, options);
  std::vector<std::array<uint32_t, 4>> quads;
  for_each_quad(scene, [&](const std::array<uint32_t, 4>& quad) {
    if (rule.allows(quad)) quads.push_back(quad);
  });
  return quads;
}

std::vector<std::array<uint32_t, 3>> thesis_triangles(const ScenePoints& scene,
                                                      const ThesisMeshOptions& options) {
  const ThesisRule rule(scene, options);
  std::vector<std::array<uint32_t, 3>> triangles;
  for_each_quad(scene, [&](const std::array<uint32_t, 4>& quad) {
    const std::array<uint32_t, 3> first{quad[0], quad[1], quad[2]};
    const std::array<uint32_t, 3> second{quad[0], quad[2], quad[3]};
    if (rule.allows(first)) triangles.push_back(first);
    if (rule.allows(second)) triangles.push_back(second);
  });
  return triangles;
}

TriangleMesh mesh_scene(const ScenePoints& scene, const SceneMeshOptions& options) {
  return Mesher(scene, options).run();
}

void append_mesh(TriangleMesh& whole, const TriangleMesh& part) {
  const auto first = static_cast<uint32_t>(whole.vertices_m.size());
  whole.vertices_m.insert(whole.vertices_m.end(), part.vertices_m.begin(), part.vertices_m.end());
  whole.normals.insert(whole.normals.end(), part.normals.begin(), part.normals.end());
  whole.colors_rgb.insert(whole.colors_rgb.end(), part.colors_rgb.begin(), part.colors_rgb.end());
  for (const auto& triangle : part.triangles) {
    whole.triangles.push_back({triangle[0] + first, triangle[1] + first, triangle[2] + first});
  }
}

}  // namespace marco::mapping3d
