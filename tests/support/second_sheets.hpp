#pragma once

#include <array>

#include "common/mesh_samples.hpp"
#include "simulator/ray_caster.hpp"

namespace marco::testing {

/// Parts of a mesh's area with another sheet that faces the same way (within 45 deg) behind it:
/// within 2, 5 and 15 cm.
inline std::array<double, 3> second_sheets(const TriangleMesh& mesh) {
  constexpr std::array<float, 3> kWithinM = {0.02F, 0.05F, 0.15F};
  constexpr float kOwnM = 1e-3F;  // nearer is the sheet itself
  sim::World world;
  world.vertices_m = mesh.vertices_m;
  world.triangles = mesh.triangles;
  world.materials.resize(mesh.triangles.size(), sim::Material::plain);
  const sim::RayCaster rays(world);
  const auto normal_of = [&](std::size_t t) -> Eigen::Vector3f {
    const auto& v = mesh.vertices_m;
    const auto& corners = mesh.triangles[t];
    return (v[corners[1]] - v[corners[0]]).cross(v[corners[2]] - v[corners[0]]).normalized();
  };
  std::size_t samples = 0;
  std::array<double, 3> doubled{};
  for_each_sample(mesh, 4e-4F, [&](const Eigen::Vector3f& point, std::size_t t) {
    ++samples;
    const Eigen::Vector3f normal = normal_of(t);
    for (float from = kOwnM; from < kWithinM.back();) {
      const auto hit = rays.cast(point - from * normal, -normal, kWithinM.back() - from);
      if (!hit) break;
      from += hit->range_m + kOwnM;
      if (normal_of(hit->triangle).dot(normal) < 0.7F) continue;
      for (std::size_t i = 0; i < doubled.size(); ++i) doubled[i] += from < kWithinM[i] ? 1.0 : 0.0;
      break;
    }
  });
  for (double& part : doubled) part /= static_cast<double>(std::max<std::size_t>(1, samples));
  return doubled;
}

}  // namespace marco::testing
