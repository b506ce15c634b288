#include "mapping3d/surface/surface_bound.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/mesh_samples.hpp"
#include "common/triangle_distance.hpp"

namespace marco::mapping3d {
namespace {

// What is sampled lies within this part of the limit; the rest is for steps without samples.
constexpr float kSampledShare = 0.95F;

// Of the slab that holds the made triangles and the replaced ones, which lie between the same
// corners. Infinite where the made ones fold: only one sheet has a part of the other over each
// place.
float thickness_m(const SurfaceBound::Step& step) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  const auto cross = [](const SurfaceBound::Corners& triangle) -> Eigen::Vector3f {
    const auto& [a, b, c] = triangle.at_m;
    return (b - a).cross(c - a);
  };
  for (const SurfaceBound::Corners& triangle : step.made) sum += cross(triangle);
  const Eigen::Vector3f normal = sum.normalized();
  float low_m = 0.0F, high_m = 0.0F;  // from the vertex that vanishes
  for (const SurfaceBound::Corners& triangle : step.made) {
    if (cross(triangle).dot(normal) < 0.0F) return kInfinite;
    for (const Eigen::Vector3f& corner : triangle.at_m) {
      const float at_m = normal.dot(corner - step.vanishes_m);
      low_m = std::min(low_m, at_m);
      high_m = std::max(high_m, at_m);
    }
  }
  return high_m - low_m;
}

}  // namespace

SurfaceBound::SurfaceBound(const TriangleMesh& original,
                           std::vector<float> begins_off_m,
                           const std::vector<uint8_t>& on_plane,
                           float limit_m,
                           float sample_m2)
    : limit_m_(limit_m),
      sample_m2_(sample_m2),
      to_original_(original, kSampledShare * limit_m),
      first_(original.triangles.size(), kNone),
      off_m_(std::move(begins_off_m)) {
  std::vector<uint8_t> is_sampled(original.vertices_m.size(), 0);
  for (std::size_t t = 0; t < first_.size(); ++t) {
    if (off_m_[t] < 0.0F) continue;
    if (!on_plane.empty() && on_plane[t] != 0) {
      first_[t] = kOnPlane;
      continue;
    }
    const auto& [a, b, c] = original.triangles[t];
    for (const uint32_t corner : {a, b, c}) {
      if (std::exchange(is_sampled[corner], uint8_t{1}) == 0) {
        add_sample(original.vertices_m[corner], 0.0F, t);
      }
    }
    for_each_sample({original.vertices_m[a], original.vertices_m[b], original.vertices_m[c]},
                    sample_m2,
                    [&](const Eigen::Vector3f& point_m) { add_sample(point_m, 0.0F, t); });
  }
}

void SurfaceBound::add_sample(const Eigen::Vector3f& point_m, float off_m, std::size_t triangle) {
  const auto number = static_cast<uint32_t>(samples_.size());
  samples_.push_back({point_m, off_m, std::exchange(first_[triangle], number)});
}

// What was original there lies within `off_m_` of it, and is over the same ground.
void SurfaceBound::sample_plane(const Corners& triangle) {
  const std::size_t number = triangle.number;
  first_[number] = kNone;
  for (const Eigen::Vector3f& corner : triangle.at_m) add_sample(corner, off_m_[number], number);
  for_each_sample(triangle.at_m, sample_m2_, [&](const Eigen::Vector3f& point_m) {
    add_sample(point_m, off_m_[number], number);
  });
}

bool SurfaceBound::allows(const Step& step) {
  made_on_plane_ = is_plane_filled(step);
  if (made_on_plane_) return true;
  for (const Corners& triangle : step.replaced) {
    if (first_[triangle.number] == kOnPlane) sample_plane(triangle);
  }
  return is_covered(step) && is_on_original(step);
}

// Whether the same part of a plane is filled again, so that nothing needs to be looked at.
bool SurfaceBound::is_plane_filled(const Step& step) {
  if (!step.stays_on_plane || !step.fills_the_ring) return false;
  moved_.clear();
  made_off_m_ = 0.0F;
  for (const Corners& triangle : step.replaced) {
    if (first_[triangle.number] != kOnPlane) return false;
    made_off_m_ = std::max(made_off_m_, off_m_[triangle.number]);
  }
  return true;
}

SurfaceBound::Foot::Foot(const Corners& corners) : at_m(corners.at_m[0].cast<double>()) {
  const Eigen::Vector3d second = corners.at_m[1].cast<double>() - at_m;
  const Eigen::Vector3d third = corners.at_m[2].cast<double>() - at_m;
  const Eigen::Vector3d cross = second.cross(third);
  const double area2 = cross.squaredNorm();
  normal = cross / std::sqrt(area2);
  to_second = third.cross(cross) / area2;
  to_third = cross.cross(second) / area2;
}

float SurfaceBound::Foot::above_m(const Eigen::Vector3f& point_m) const {
  const Eigen::Vector3d off = point_m.cast<double>() - at_m;
  const double second = to_second.dot(off), third = to_third.dot(off);
  const bool is_in = second >= 0.0 && third >= 0.0 && second + third <= 1.0;
  return is_in ? static_cast<float>(std::abs(normal.dot(off)))
               : std::numeric_limits<float>::infinity();
}

// From the original to the mesh. Most samples have a foot on a triangle; the others are looked at
// closely.
bool SurfaceBound::is_covered(const Step& step) {
  moved_.clear();
  feet_.clear();
  for (const Corners& triangle : step.made) feet_.emplace_back(triangle);
  for (const Corners& from : step.replaced) {
    for (uint32_t sample = first_[from.number]; sample != kNone; sample = samples_[sample].next) {
      const Eigen::Vector3f& point_m = samples_[sample].at_m;
      const float limit_m = limit_m_ - samples_[sample].off_m;
      float best_m = limit_m;
      uint32_t best = kNone;
      for (std::size_t i = 0; i < feet_.size(); ++i) {
        const float own_m = feet_[i].above_m(point_m);
        if (!(own_m < best_m)) continue;  // it may be no number
        best_m = own_m;
        best = step.made[i].number;
      }
      if (best == kNone) best = nearest(step, point_m, limit_m);
      if (best == kNone) return false;
      moved_.emplace_back(sample, best);
    }
  }
  return true;
}

// The number of a triangle within the limit, or none.
uint32_t SurfaceBound::nearest(const Step& step,
                               const Eigen::Vector3f& point_m,
                               float limit_m) const {
  float best_m2 = limit_m * limit_m;
  uint32_t best = kNone;
  const auto look = [&](const Corners& triangle) {
    const auto& [a, b, c] = triangle.at_m;
    const float own_m2 = squared_distance(point_m, a, b, c);
    if (!(own_m2 < best_m2)) return;
    best_m2 = own_m2;
    best = triangle.number;
  };
  for (const Corners& triangle : step.made) look(triangle);
  for (const Corners& triangle : step.beside) look(triangle);
  return best;
}

// From the mesh to the original. Where both lie between two close planes, no sample needs to be
// looked at.
bool SurfaceBound::is_on_original(const Step& step) {
  made_off_m_ = 0.0F;
  for (const Corners& triangle : step.replaced) {
    made_off_m_ = std::max(made_off_m_, off_m_[triangle.number]);
  }
  if (step.fills_the_ring) {
    made_off_m_ += thickness_m(step);
    if (made_off_m_ <= limit_m_) return true;
  }
  made_off_m_ = to_original_.max_m();
  return std::all_of(step.made.begin(), step.made.end(),
                     [this](const Corners& triangle) { return is_sampled_on_original(triangle); });
}

// Slivers have hardly any area to sample, but edges.
bool SurfaceBound::is_sampled_on_original(const Corners& triangle) const {
  const float step_m = std::sqrt(sample_m2_);
  for (std::size_t side = 0; side < 3; ++side) {
    const Eigen::Vector3f& from = triangle.at_m[side];
    const Eigen::Vector3f edge = triangle.at_m[(side + 1) % 3] - from;
    const int steps = static_cast<int>(edge.norm() / step_m);
    for (int i = 1; i < steps; ++i) {
      const float part = static_cast<float>(i) / static_cast<float>(steps);
      if (!to_original_.any_within(from + part * edge)) return false;
    }
  }
  bool is_on = true;
  for_each_sample(triangle.at_m, sample_m2_, [&](const Eigen::Vector3f& point_m) {
    is_on = is_on && to_original_.any_within(point_m);
  });
  return is_on;
}

void SurfaceBound::take(const Step& step) {
  for (const Corners& from : step.replaced) first_[from.number] = kNone;
  for (const Corners& triangle : step.beside) {
    const bool gets_samples = std::any_of(moved_.begin(), moved_.end(), [&](const auto& moved) {
      return moved.second == triangle.number;
    });
    if (gets_samples && first_[triangle.number] == kOnPlane) sample_plane(triangle);
  }
  for (const auto& [sample, triangle] : moved_) {
    samples_[sample].next = std::exchange(first_[triangle], sample);
  }
  for (const Corners& triangle : step.made) {
    off_m_[triangle.number] = made_off_m_;
    if (made_on_plane_) first_[triangle.number] = kOnPlane;
  }
}

double SurfaceBound::largest_m(
    const std::function<std::array<Eigen::Vector3f, 3>(std::size_t)>& corners_m) const {
  float largest_m = 0.0F;
  for (std::size_t t = 0; t < first_.size(); ++t) {
    if (first_[t] == kOnPlane) {
      largest_m = std::max(largest_m, off_m_[t]);
      continue;
    }
    if (first_[t] == kNone) continue;
    const auto [a, b, c] = corners_m(t);
    for (uint32_t i = first_[t]; i != kNone; i = samples_[i].next) {
      const float own_m = std::sqrt(squared_distance(samples_[i].at_m, a, b, c));
      largest_m = std::max(largest_m, own_m + samples_[i].off_m);
    }
  }
  return static_cast<double>(largest_m);
}

}  // namespace marco::mapping3d
