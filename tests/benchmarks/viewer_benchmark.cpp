// Frames a second at 1280x720 with some 200 000 triangles: the renderer, the renderer with its
// pictures read back and shaded, and a bare glDrawElements of the same buffers into the same
// target.
#include <benchmark/benchmark.h>

#include "tests/unit/viewer/tiny_room.hpp"
#include "viewer/renderer.hpp"

namespace marco::viewer {
namespace {

constexpr PictureSize kSize{1280, 720};

Renderer& loaded_renderer() {
  static Renderer* const renderer = [] {
    auto* made = new Renderer();
    made->load(testing::room_scene(0.0325F, 0.003F));
    return made;
  }();
  return *renderer;
}

Camera in_the_room() { return camera_at(make_pose3({0.4, 2.0, 1.4})); }

Look bare_look() {
  Look look;
  look.supersampling = 1;
  look.occlusion_radius_m = 0.0;
  return look;
}

void count_frames(benchmark::State& state) {
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
  state.counters["triangles"] = static_cast<double>(loaded_renderer().triangle_count());
}

void bare_draw_elements(benchmark::State& state) {
  Renderer& renderer = loaded_renderer();
  renderer.draw_unread(in_the_room(), bare_look(), kSize);
  for (auto _ : state) renderer.draw_bare();
  count_frames(state);
}
BENCHMARK(bare_draw_elements)->Unit(benchmark::kMillisecond)->UseRealTime();

void frame_unread(benchmark::State& state) {
  for (auto _ : state) loaded_renderer().draw_unread(in_the_room(), bare_look(), kSize);
  count_frames(state);
}
BENCHMARK(frame_unread)->Unit(benchmark::kMillisecond)->UseRealTime();

// Surfaces may be off by two pixels.
void frame_unread_with_level_of_detail(benchmark::State& state) {
  Look look = bare_look();
  look.detail_px = 2.0;
  loaded_renderer().draw_unread(in_the_room(), look, kSize);  // makes the levels
  for (auto _ : state) loaded_renderer().draw_unread(in_the_room(), look, kSize);
  count_frames(state);
}
BENCHMARK(frame_unread_with_level_of_detail)->Unit(benchmark::kMillisecond)->UseRealTime();

void frame_read_back(benchmark::State& state) {
  for (auto _ : state)
    benchmark::DoNotOptimize(loaded_renderer().draw(in_the_room(), bare_look(), kSize));
  count_frames(state);
}
BENCHMARK(frame_read_back)->Unit(benchmark::kMillisecond)->UseRealTime();

void picture_at_full_quality(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(loaded_renderer().draw(in_the_room(), {}, kSize));
  count_frames(state);
}
BENCHMARK(picture_at_full_quality)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace marco::viewer
