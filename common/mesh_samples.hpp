#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/triangle_mesh.hpp"

namespace marco {

/// Calls `visit(point_m, triangle)` with points spread evenly over a mesh: one for each
/// `area_each_m2` of every triangle, at least one a triangle (its centre), always the same: the R2
/// sequence (Roberts 2018), folded into the triangle.
template <class Visit>
void for_each_sample(const TriangleMesh& mesh, float area_each_m2, const Visit& visit) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& triangle = mesh.triangles[t];
    const Eigen::Vector3f a = mesh.vertices_m[triangle[0]];
    const Eigen::Vector3f ab = mesh.vertices_m[triangle[1]] - a;
    const Eigen::Vector3f ac = mesh.vertices_m[triangle[2]] - a;
    const float area_m2 = 0.5F * ab.cross(ac).norm();
    const int count = static_cast<int>(std::clamp(area_m2 / area_each_m2, 1.0F, 1e7F));
    for (int i = 0; i < count; ++i) {
      // In double: a large wall takes many points.
      double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0);
      double v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
      if (count == 1) u = v = 1.0 / 3.0;
      if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
      }
      visit(Eigen::Vector3f(a + static_cast<float>(u) * ab + static_cast<float>(v) * ac), t);
    }
  }
}

}  // namespace marco
