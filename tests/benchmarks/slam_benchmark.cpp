#include <benchmark/benchmark.h>

#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/surfel_matcher.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

constexpr double kNoiseM = 0.01;

// A local map of fifteen keyframes along two metres of a room, 361 beams each.
struct Fixture {
  Fixture() : map({}, {0, 0}) {
    for (int i = 0; i < 15; ++i) {
      const Pose2 pose{-1.0 + 0.14 * i, 0.02 * i, 0.05 * i};
      map.add(orient(room.hits(pose, kNoiseM, &random), {0, 0}, {}), pose);
    }
    hits = room.hits(truth, kNoiseM, &random);
  }
  testing::FlatWorld room = testing::small_room();
  std::mt19937 random{7};
  SurfelPyramid map;
  Pose2 truth{0.5, 0.2, 0.4};
  Points2 hits;
};

void match_361_beams_against_local_map(benchmark::State& state) {
  const Fixture fixture;
  const SurfelMatcher matcher;
  const OrientedPoints points = orient(fixture.hits, {0, 0}, {});
  const Pose2 start = fixture.truth * Pose2{0.05, -0.03, 0.03};
  int64_t iterations = 0;
  for (auto _ : state) {
    const SurfelMatch match = matcher.match(fixture.map, points, start, nullptr);
    iterations += match.iterations;
    benchmark::DoNotOptimize(match);
  }
  state.counters["iterations"] =
      benchmark::Counter(static_cast<double>(iterations), benchmark::Counter::kAvgIterations);
}
BENCHMARK(match_361_beams_against_local_map)->Unit(benchmark::kMicrosecond);

void orient_361_beams(benchmark::State& state) {
  const Fixture fixture;
  for (auto _ : state) benchmark::DoNotOptimize(orient(fixture.hits, {0, 0}, {}));
}
BENCHMARK(orient_361_beams)->Unit(benchmark::kMicrosecond);

void make_local_map_of_15_scans(benchmark::State& state) {
  const Fixture fixture;
  const OrientedPoints points = orient(fixture.hits, {0, 0}, {});
  for (auto _ : state) {
    SurfelPyramid map({}, {0, 0});
    for (int i = 0; i < 15; ++i) map.add(points, {0.1 * i, 0, 0});
    benchmark::DoNotOptimize(map);
  }
}
BENCHMARK(make_local_map_of_15_scans)->Unit(benchmark::kMicrosecond);

// Half-widths of the window: metres / 10 and degrees.
void search_exhaustively(benchmark::State& state) {
  const Fixture fixture;
  const CorrelativeMatcher matcher;
  const LikelihoodPyramid map(fixture.room.hits({0, 0, 0}), {});
  const SearchWindow window{{0, 0, 0},
                            0.1 * static_cast<double>(state.range(0)),
                            deg_to_rad(static_cast<double>(state.range(1)))};
  for (auto _ : state) {
    benchmark::DoNotOptimize(matcher.search(map, fixture.hits, window, 0.3));
  }
}
BENCHMARK(search_exhaustively)
    ->Args({10, 20})
    ->Args({40, 30})
    ->Args({80, 180})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace marco::slam
