#include "mapping3d/surface/mesh_distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/mesh_samples.hpp"
#include "lcm_tools/base/check.hpp"
#include "mapping3d/surface/triangle_distance.hpp"

namespace marco::mapping3d {

MeshDistance::MeshDistance(const TriangleMesh& mesh, float max_m)
    : mesh_(mesh), max_m_(max_m), cell_m_(std::max(0.1F, 2.0F * max_m)) {
  require(max_m > 0.0F, "MeshDistance: max_m must be above 0");
  balls_.reserve(mesh.triangles.size());
  const float reach_m = 0.5F * std::sqrt(3.0F) * cell_m_ + max_m_;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    const Eigen::Vector3f &a = mesh.vertices_m[corners[0]], &b = mesh.vertices_m[corners[1]],
                          &c = mesh.vertices_m[corners[2]];
    const Eigen::Vector3f centre = (a + b + c) / 3.0F;
    const float radius2 = std::max(
        {(a - centre).squaredNorm(), (b - centre).squaredNorm(), (c - centre).squaredNorm()});
    balls_.push_back({centre, std::sqrt(radius2)});
    const Eigen::Vector3f normal = (b - a).cross(c - a).normalized();
    const Eigen::Vector3f grown = Eigen::Vector3f::Constant(max_m_);
    const Eigen::Vector3i low = cell_of(a.cwiseMin(b).cwiseMin(c) - grown);
    const Eigen::Vector3i high = cell_of(a.cwiseMax(b).cwiseMax(c) + grown);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const Eigen::Vector3i cell(x, y, z);
          const Eigen::Vector3f middle =
              (cell.cast<float>() + Eigen::Vector3f::Constant(0.5F)) * cell_m_;
          if (std::abs(normal.dot(middle - a)) > reach_m) continue;
          triangles_[key(cell)].push_back(static_cast<uint32_t>(t));
        }
      }
    }
  }
}

Eigen::Vector3i MeshDistance::cell_of(const Eigen::Vector3f& point_m) const {
  return (point_m / cell_m_).array().floor().matrix().cast<int>();
}

uint64_t MeshDistance::key(const Eigen::Vector3i& cell) const {
  const auto part = [&](int axis) {
    return uint64_t{(1U << 20U) + static_cast<uint32_t>(cell[axis])};
  };
  return part(0) | (part(1) << 21U) | (part(2) << 42U);
}

float MeshDistance::operator()(const Eigen::Vector3f& point_m) const {
  const auto found = triangles_.find(key(cell_of(point_m)));
  if (found == triangles_.end()) return max_m_;
  float best_m = max_m_, best_m2 = max_m_ * max_m_;
  for (const uint32_t t : found->second) {
    const float reach_m = balls_[t].radius_m + best_m;
    if ((point_m - balls_[t].centre_m).squaredNorm() > reach_m * reach_m) continue;
    const auto& corners = mesh_.triangles[t];
    const float own_m2 =
        squared_distance(point_m, mesh_.vertices_m[corners[0]], mesh_.vertices_m[corners[1]],
                         mesh_.vertices_m[corners[2]]);
    if (!(own_m2 < best_m2)) continue;  // of a triangle without area it may be no number
    best_m2 = own_m2;
    best_m = std::sqrt(own_m2);
  }
  return best_m;
}

bool MeshDistance::any_within(const Eigen::Vector3f& point_m) const {
  const auto found = triangles_.find(key(cell_of(point_m)));
  if (found == triangles_.end()) return false;
  const float max2_m2 = max_m_ * max_m_;
  for (const uint32_t t : found->second) {
    if ((point_m - balls_[t].centre_m).squaredNorm() < max2_m2) return true;  // it lies on it
  }
  return (*this)(point_m) < max_m_;
}

MeshGap gap(const TriangleMesh& from, const MeshDistance& to, float area_each_m2) {
  MeshGap found;
  double squares = 0.0;
  float carried_m2 = area_each_m2;
  for_each_sample(from, area_each_m2, [&](const Eigen::Vector3f& point, std::size_t triangle) {
    const auto& t = from.triangles[triangle];
    const auto& v = from.vertices_m;
    carried_m2 +=
        std::min(area_each_m2, 0.5F * (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm());
    if (carried_m2 < area_each_m2) return;
    carried_m2 -= area_each_m2;
    const auto d = static_cast<double>(to(point));
    ++found.samples;
    squares += d * d;
    found.max_m = std::max(found.max_m, d);
  });
  if (found.samples == 0) return found;
  found.rms_m = std::sqrt(squares / static_cast<double>(found.samples));
  return found;
}

}  // namespace marco::mapping3d
