#include "common/mesh_distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/mesh_samples.hpp"
#include "common/triangle_distance.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco {

namespace {

uint64_t key_of(const Eigen::Vector3i& cell) {
  const auto part = [&](int axis) {
    return uint64_t{(1U << 20U) + static_cast<uint32_t>(cell[axis])};
  };
  return part(0) | (part(1) << 21U) | (part(2) << 42U);
}

// Cells as large as a few triangles: in smaller ones each lies in many, in larger ones a query
// looks at many.
float cell_m_for(const TriangleMesh& mesh, float max_m) {
  double sum_m = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum_m += static_cast<double>((mesh.vertices_m[b] - mesh.vertices_m[a]).norm());
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, mesh.triangles.size()));
  return std::max(2.0F * max_m, static_cast<float>(3.0 * sum_m / count));
}

}  // namespace

MeshDistance::MeshDistance(const TriangleMesh& mesh, float max_m)
    : mesh_(mesh), max_m_(max_m), cell_m_(cell_m_for(mesh, max_m)), slots_(1U << 10U) {
  require(max_m > 0.0F, "MeshDistance: max_m must be above 0");
  balls_.reserve(mesh.triangles.size());
  for (const auto& corners : mesh.triangles) {
    const Eigen::Vector3f &a = mesh.vertices_m[corners[0]], &b = mesh.vertices_m[corners[1]],
                          &c = mesh.vertices_m[corners[2]];
    const Eigen::Vector3f centre = (a + b + c) / 3.0F;
    const float radius2 = std::max(
        {(a - centre).squaredNorm(), (b - centre).squaredNorm(), (c - centre).squaredNorm()});
    balls_.push_back({centre, std::sqrt(radius2)});
  }
  std::size_t entries = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for_each_cell_of(t, [&](uint64_t key) {
      Slot* slot = &slots_[slot_of(key)];
      if (slot->key == kFree) {
        slot->key = key;
        if (2 * ++cells_ > slots_.size()) {
          grow_slots();
          slot = &slots_[slot_of(key)];
        }
      }
      ++slot->count;
      ++entries;
    });
  }
  triangles_.resize(entries);
  std::size_t first = 0;
  for (Slot& slot : slots_) {
    slot.first = first;
    first += std::exchange(slot.count, 0U);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for_each_cell_of(t, [&](uint64_t key) {
      Slot& slot = slots_[slot_of(key)];
      triangles_[slot.first + slot.count++] = static_cast<uint32_t>(t);
    });
  }
}

template <class Visit>
void MeshDistance::for_each_cell_of(std::size_t triangle, const Visit& visit) const {
  const auto& corners = mesh_.triangles[triangle];
  const Eigen::Vector3f &a = mesh_.vertices_m[corners[0]], &b = mesh_.vertices_m[corners[1]],
                        &c = mesh_.vertices_m[corners[2]];
  const float reach_m = 0.5F * std::sqrt(3.0F) * cell_m_ + max_m_;
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
        if (!(std::abs(normal.dot(middle - a)) > reach_m)) visit(key_of(cell));
      }
    }
  }
}

void MeshDistance::grow_slots() {
  std::vector<Slot> old(2 * slots_.size());
  old.swap(slots_);
  for (const Slot& from : old) {
    if (from.key != kFree) slots_[slot_of(from.key)] = from;
  }
}

// Of a cell, or the free one where it would be.
std::size_t MeshDistance::slot_of(uint64_t key) const {
  const std::size_t last = slots_.size() - 1;
  std::size_t slot = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 20U) & last;
  while (slots_[slot].key != key && slots_[slot].key != kFree) slot = (slot + 1) & last;
  return slot;
}

Eigen::Vector3i MeshDistance::cell_of(const Eigen::Vector3f& point_m) const {
  return (point_m / cell_m_).array().floor().matrix().cast<int>();
}

std::span<const uint32_t> MeshDistance::near(const Eigen::Vector3f& point_m) const {
  const Slot& slot = slots_[slot_of(key_of(cell_of(point_m)))];
  return {triangles_.data() + slot.first, slot.count};
}

bool MeshDistance::may_reach(uint32_t triangle,
                             const Eigen::Vector3f& point_m,
                             float within_m) const {
  const float reach_m = balls_[triangle].radius_m + within_m;
  return !((point_m - balls_[triangle].centre_m).squaredNorm() > reach_m * reach_m);
}

// Of a triangle without area it may be no number.
float MeshDistance::squared_m2(uint32_t triangle, const Eigen::Vector3f& point_m) const {
  const auto& [a, b, c] = mesh_.triangles[triangle];
  return squared_distance(point_m, mesh_.vertices_m[a], mesh_.vertices_m[b], mesh_.vertices_m[c]);
}

float MeshDistance::operator()(const Eigen::Vector3f& point_m) const {
  float best_m = max_m_, best_m2 = max_m_ * max_m_;
  for (const uint32_t t : near(point_m)) {
    if (!may_reach(t, point_m, best_m)) continue;
    const float own_m2 = squared_m2(t, point_m);
    if (!(own_m2 < best_m2)) continue;
    best_m2 = own_m2;
    best_m = std::sqrt(own_m2);
  }
  return best_m;
}

bool MeshDistance::any_within(const Eigen::Vector3f& point_m) const {
  const std::span<const uint32_t> all = near(point_m);
  const float max2_m2 = max_m_ * max_m_;
  // Their middles lie on them, and are looked at faster.
  return std::any_of(
             all.begin(), all.end(),
             [&](uint32_t t) { return (point_m - balls_[t].centre_m).squaredNorm() < max2_m2; }) ||
         std::any_of(all.begin(), all.end(), [&](uint32_t t) {
           return may_reach(t, point_m, max_m_) && squared_m2(t, point_m) < max2_m2;
         });
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

}  // namespace marco
