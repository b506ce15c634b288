// The mesh of one scene: 361 x 100 beams in a room (36 100 points), with normals and without the
// placing.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "mapping3d/scene_mesh.hpp"

namespace {

using marco::deg_to_rad;
using marco::mapping3d::ScenePoints;

// From the middle of a room of 8 x 6 x 2.6 m, 1 cm noise.
ScenePoints room_scene() {
  ScenePoints scene;
  scene.rows = 100;
  scene.columns = 361;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.01);
  for (std::size_t row = 0; row < scene.rows; ++row) {
    const double tilt = deg_to_rad(-20.0 + 0.65 * static_cast<double>(row));
    scene.origins_m.emplace_back(0.0F, 0.0F, 0.5F);
    for (std::size_t column = 0; column < scene.columns; ++column) {
      const double bearing = deg_to_rad(-90.0 + 0.5 * static_cast<double>(column));
      const Eigen::Vector3d ray(std::cos(bearing) * std::cos(tilt), std::sin(bearing),
                                std::cos(bearing) * std::sin(tilt));
      const double to_wall = std::min(4.0 / std::max(1e-9, std::abs(ray.x())),
                                      3.0 / std::max(1e-9, std::abs(ray.y())));
      const double to_level = (ray.z() > 0 ? 2.1 : 0.5) / std::max(1e-9, std::abs(ray.z()));
      const Eigen::Vector3d hit =
          Eigen::Vector3d(0, 0, 0.5) + (std::min(to_wall, to_level) + noise(random)) * ray;
      scene.points_m.push_back(hit.cast<float>());
      scene.valid.push_back(1);
    }
  }
  return scene;
}

void mesh_of_a_scene(benchmark::State& state) {
  const ScenePoints scene = room_scene();
  std::size_t triangles = 0;
  for (auto _ : state) {
    const marco::TriangleMesh mesh = marco::mapping3d::mesh_scene(scene);
    triangles = mesh.triangles.size();
    benchmark::DoNotOptimize(mesh.normals.data());
  }
  state.counters["triangles"] = static_cast<double>(triangles);
  state.counters["triangles_per_s"] = benchmark::Counter(
      static_cast<double>(triangles), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(mesh_of_a_scene)->Unit(benchmark::kMicrosecond);

void thesis_triangles_of_a_scene(benchmark::State& state) {
  const ScenePoints scene = room_scene();
  for (auto _ : state) benchmark::DoNotOptimize(marco::mapping3d::thesis_triangles(scene));
}
BENCHMARK(thesis_triangles_of_a_scene)->Unit(benchmark::kMicrosecond);

}  // namespace
