#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "common/triangle_mesh.hpp"

namespace marco {

/// Calls `visit(point_m)` with points spread evenly over a triangle: one for each `area_each_m2`,
/// at least one (its centre), always the same: the R2 sequence (Roberts 2018), folded into the
/// triangle.
template <class Visit>
void for_each_sample(const std::array<Eigen::Vector3f, 3>& corners_m,
                     float area_each_m2,
                     const Visit& visit) {
  const Eigen::Vector3f& a = corners_m[0];
  const Eigen::Vector3f ab = corners_m[1] - a, ac = corners_m[2] - a;
  const float area_m2 = 0.5F * ab.cross(ac).norm();
  const int count = static_cast<int>(std::clamp(area_m2 / area_each_m2, 1.0F, 1e7F));
  const auto fraction = [](double of) { return of - static_cast<double>(static_cast<int>(of)); };
  for (int i = 0; i < count; ++i) {
    // In double: a large wall takes many points.
    double u = fraction(0.5 + 0.7548776662466927 * i);
    double v = fraction(0.5 + 0.5698402909980532 * i);
    if (count == 1) u = v = 1.0 / 3.0;
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    visit(Eigen::Vector3f(a + static_cast<float>(u) * ab + static_cast<float>(v) * ac));
  }
}

inline double surface_area_m2(const TriangleMesh& mesh) {
  double sum_m2 = 0.0;
  const auto& at_m = mesh.vertices_m;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum_m2 += 0.5 * static_cast<double>((at_m[b] - at_m[a]).cross(at_m[c] - at_m[a]).norm());
  }
  return sum_m2;
}

/// Those of a mesh, as `visit(point_m, triangle)`.
template <class Visit>
void for_each_sample(const TriangleMesh& mesh, float area_each_m2, const Visit& visit) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    for_each_sample({mesh.vertices_m[a], mesh.vertices_m[b], mesh.vertices_m[c]}, area_each_m2,
                    [&](const Eigen::Vector3f& point_m) { visit(point_m, t); });
  }
}

}  // namespace marco
