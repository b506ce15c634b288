// One surface from scenes of 361 x 100 beams in a room (36 100 points): what merging one costs at
// 5 cm, in its parts, and drawing the whole.
#include <benchmark/benchmark.h>

#include <optional>

#include "mapping3d/surface/simplify.hpp"
#include "mapping3d/surface/surface_model.hpp"
#include "tests/unit/mapping3d_surface/box_world.hpp"

namespace {

using namespace marco::mapping3d;

ScenePoints room_scene(unsigned seed) {
  testing::Sweep by;
  by.rows = 100;
  by.columns = 361;
  by.tilt_first_deg = -20.0;
  by.tilt_step_deg = 0.65;
  by.sigma_m = 0.005;
  by.heading_rad = 0.05 * seed;
  by.from.x() = 0.23 * seed;
  by.seed = seed;
  return testing::sweep({{-4, -3, 0}, {4, 3, 2.6}},
                        {{{1.5, 1.0, 0}, {2.1, 1.8, 1.1}}, {{2.0, -1.6, 0}, {2.5, -0.9, 0.8}}}, by);
}

SurfaceOptions options() {
  SurfaceOptions options;
  options.voxel_m = 0.05;
  return options;
}

// A second scene into a model that holds the first: smoothing, distances, carving.
void merge_a_scene(benchmark::State& state) {
  const bool carve = state.range(0) != 0;
  const ScenePoints second = room_scene(2);
  const BeamNoise noise = learn_noise({second});
  const SmoothScene first = smooth(room_scene(1), noise);
  std::optional<SurfaceModel> model;
  for (auto _ : state) {
    state.PauseTiming();
    model.emplace(options());
    model->add(first);
    state.ResumeTiming();
    const SmoothScene scene = smooth(second, noise);
    model->add(scene);
    if (carve) model->carve(second, model->free_beams(scene));
    benchmark::DoNotOptimize(model->block_count());
  }
}
BENCHMARK(merge_a_scene)->Arg(0)->Arg(1)->ArgName("carve")->Unit(benchmark::kMillisecond);

void smooth_a_scene(benchmark::State& state) {
  const ScenePoints scene = room_scene(1);
  const BeamNoise noise = learn_noise({scene});
  for (auto _ : state) benchmark::DoNotOptimize(smooth(scene, noise).points_m.data());
}
BENCHMARK(smooth_a_scene)->Unit(benchmark::kMillisecond);

void draw_the_surface(benchmark::State& state) {
  const BeamNoise noise = learn_noise({room_scene(1)});
  const SmoothScene first = smooth(room_scene(1), noise), second = smooth(room_scene(2), noise);
  std::size_t triangles = 0;
  for (auto _ : state) {
    state.PauseTiming();
    SurfaceModel model(options());
    model.add(first);
    model.add(second);
    state.ResumeTiming();
    const marco::TriangleMesh mesh = model.take_mesh();
    triangles = mesh.triangles.size();
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(draw_the_surface)->Unit(benchmark::kMillisecond);

void simplify_the_surface(benchmark::State& state) {
  const marco::TriangleMesh mesh = fuse({room_scene(1), room_scene(2)}, options());
  std::size_t triangles = 0;
  for (auto _ : state) triangles = simplify(mesh, find_planes(mesh)).mesh.triangles.size();
  state.counters["of"] = static_cast<double>(mesh.triangles.size());
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(simplify_the_surface)->Unit(benchmark::kMillisecond);

}  // namespace
