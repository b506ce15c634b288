// The mesh of one scene: 361 x 100 beams in a room (36 100 points), with normals and without the
// placing; the placing; and the joining of two such scenes.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "mapping3d/registration.hpp"
#include "mapping3d/scene_mesh.hpp"
#include "mapping3d/thesis_mesh.hpp"
#include "tests/support/analytic_room.hpp"
#include "tests/support/slow_scene_mesh.hpp"

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

void mesh_of_a_scene_quad_by_quad(benchmark::State& state) {
  const ScenePoints scene = room_scene();
  for (auto _ : state) benchmark::DoNotOptimize(marco::testing::SlowMesher(scene).run());
}
BENCHMARK(mesh_of_a_scene_quad_by_quad)->Unit(benchmark::kMicrosecond);

void thesis_triangles_of_a_scene(benchmark::State& state) {
  const ScenePoints scene = room_scene();
  for (auto _ : state) benchmark::DoNotOptimize(marco::mapping3d::thesis_triangles(scene));
}
BENCHMARK(thesis_triangles_of_a_scene)->Unit(benchmark::kMicrosecond);

void place_a_scene(benchmark::State& state) {
  std::mt19937 random(1);
  const marco::mapping3d::Scene scene =
      marco::testing::AnalyticRoom::sweep(marco::make_pose3({-1.0, 0.2, 0.8}), 100, 0.01, random);
  for (auto _ : state) benchmark::DoNotOptimize(marco::mapping3d::place(scene));
}
BENCHMARK(place_a_scene)->Unit(benchmark::kMicrosecond);

// Two scenes 0.23 m and 3 deg apart, noise in mm as argument; what is left is of the pose.
void align_two_scenes(benchmark::State& state) {
  using marco::testing::AnalyticRoom;
  std::mt19937 random(11);
  const double sigma_m = 1e-3 * static_cast<double>(state.range(0));
  std::vector<ScenePoints> scenes;
  scenes.push_back(marco::mapping3d::place(
      AnalyticRoom::sweep(marco::make_pose3({-1.0, 0.2, 0.8}), 100, sigma_m, random)));
  scenes.push_back(marco::mapping3d::place(AnalyticRoom::sweep(
      marco::make_pose3({-0.6, -0.5, 0.8}, 0.0, 0.0, 0.3), 100, sigma_m, random)));
  const marco::Pose3 error =
      marco::make_pose3({0.18, -0.12, 0.08}, deg_to_rad(1.0), deg_to_rad(-1.0), deg_to_rad(2.6));
  marco::mapping3d::move(scenes[1], error);
  marco::mapping3d::RegistrationResult result;
  for (auto _ : state) result = marco::mapping3d::register_scenes(scenes);
  const marco::Pose3 left = result.world_from_placed[1] * error;
  state.counters["left_mm"] = 1e3 * left.translation().norm();
  state.counters["left_mdeg"] = 1e3 * marco::rad_to_deg(Eigen::AngleAxisd(left.linear()).angle());
}
BENCHMARK(align_two_scenes)->Arg(0)->Arg(5)->Arg(10)->Unit(benchmark::kMillisecond);

}  // namespace
