#include "simulator/truth.hpp"

#include <algorithm>
#include <cmath>

namespace marco::sim {
namespace {

constexpr float kFarthestM = 1.0F;
constexpr int kOccupiedPercent = 60;

SurfaceError summarize(std::vector<float>& errors_m) {
  SurfaceError result;
  result.count = errors_m.size();
  if (errors_m.empty()) return result;
  double squares = 0.0;
  for (const float error : errors_m)
    squares += static_cast<double>(error) * static_cast<double>(error);
  result.rms_m = std::sqrt(squares / static_cast<double>(errors_m.size()));
  std::sort(errors_m.begin(), errors_m.end());
  const auto part = [&](double share) {
    return static_cast<double>(
        errors_m[static_cast<std::size_t>(share * static_cast<double>(errors_m.size() - 1))]);
  };
  result.p95_m = part(0.95);
  result.p99_m = part(0.99);
  return result;
}

}  // namespace

SurfaceError map_error(const GridMap& map,
                       const RayCaster& world,
                       const Pose2& world_from_map,
                       double laser_height_m) {
  std::vector<float> errors_m;
  for (int y = 0; y < map.height_cells; ++y) {
    for (int x = 0; x < map.width_cells; ++x) {
      const uint8_t occupied = map.at(x, y);
      if (occupied == GridMap::kUnknown || occupied < kOccupiedPercent) continue;
      const Eigen::Vector2d centre =
          map.origin_m + map.resolution_m * Eigen::Vector2d(x + 0.5, y + 0.5);
      const Eigen::Vector2d in_world = world_from_map * centre;
      errors_m.push_back(world.distance_to_surface_m(
          Eigen::Vector3d(in_world.x(), in_world.y(), laser_height_m).cast<float>(), kFarthestM));
    }
  }
  return summarize(errors_m);
}

SurfaceError model_error(const TriangleMesh& model,
                         const RayCaster& world,
                         const Pose3& world_from_model) {
  constexpr float kAreaEachM2 = 4e-4F;
  const Eigen::Isometry3f pose = world_from_model.cast<float>();
  std::vector<float> errors_m;
  for (const auto& triangle : model.triangles) {
    const Eigen::Vector3f a = pose * model.vertices_m[triangle[0]];
    const Eigen::Vector3f ab = pose * model.vertices_m[triangle[1]] - a;
    const Eigen::Vector3f ac = pose * model.vertices_m[triangle[2]] - a;
    const float area_m2 = 0.5F * ab.cross(ac).norm();
    const int count = std::clamp(static_cast<int>(area_m2 / kAreaEachM2), 1, 10000);
    for (int i = 0; i < count; ++i) {
      // Points of the R2 sequence (Roberts 2018), folded into the triangle: even, and always the
      // same.
      float u = std::fmod(0.5F + 0.7548777F * static_cast<float>(i), 1.0F);
      float v = std::fmod(0.5F + 0.5698403F * static_cast<float>(i), 1.0F);
      if (count == 1) u = v = 1.0F / 3.0F;
      if (u + v > 1.0F) {
        u = 1.0F - u;
        v = 1.0F - v;
      }
      errors_m.push_back(world.distance_to_surface_m(a + u * ab + v * ac, kFarthestM));
    }
  }
  return summarize(errors_m);
}

}  // namespace marco::sim
