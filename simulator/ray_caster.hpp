#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "simulator/world.hpp"

namespace marco::sim {

struct RayHit {
  float range_m = 0.0F;
  Eigen::Vector3f normal =
      Eigen::Vector3f::Zero();  ///< of the triangle, unit length, towards the ray
  Material material = Material::plain;
  uint32_t triangle = 0;  ///< of the world
};

struct NearestSurface {
  float distance_m = 0.0F;
  Eigen::Vector3f point_m = Eigen::Vector3f::Zero();
  uint32_t triangle = 0;  ///< of the world
};

/// Ray casting and nearest-surface search in a world, by Embree. Const members are safe from
/// several threads and deterministic.
class RayCaster {
 public:
  explicit RayCaster(const World& world);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;

  /// @param direction unit length. @returns nothing when nothing is hit within `max_range_m`.
  std::optional<RayHit> cast(const Eigen::Vector3f& origin_m,
                             const Eigen::Vector3f& direction,
                             float max_range_m) const;

  /// Distance from a point to the nearest surface; `max_m` when it is farther.
  float distance_to_surface_m(const Eigen::Vector3f& point_m, float max_m) const;

  /// The nearest point on a surface. @returns nothing when it is farther than `max_m`.
  std::optional<NearestSurface> nearest(const Eigen::Vector3f& point_m, float max_m) const;

  const World& world() const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace marco::sim
