#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "slam/matching/nlm_matcher.hpp"
#include "tests/support/matching_world.hpp"

namespace marco::slam {
namespace {

using testing::MatchingLaser;
using testing::take_scan;

constexpr int kScans = 50;

/// Keyframes of the room and scans between them with a start as wrong as odometry makes it.
struct Course {
  std::vector<Points2> keys, sources;
  std::vector<Pose2> starts;
};

Course course(int beams) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto world = testing::matching_room();
  MatchingLaser laser;
  laser.beams = beams;
  laser.step_rad = std::numbers::pi / (beams - 1);
  laser.outlier_part = 0.05;
  Course c;
  for (int i = 0; i < kScans; ++i) {
    const Pose2 key{3.6 + uniform(random), 3.2 + 0.6 * uniform(random), 3.0 * uniform(random)};
    const Pose2 truth =
        key * Pose2{0.3 * uniform(random), 0.1 * uniform(random), 0.2 * uniform(random)};
    c.keys.push_back(take_scan(world, key, laser, random).points_in_robot);
    c.sources.push_back(take_scan(world, truth, laser, random).points_in_robot);
    c.starts.push_back(between(key, truth) * Pose2{0.03 * uniform(random), 0.03 * uniform(random),
                                                   0.02 * uniform(random)});
  }
  return c;
}

void nlm_match(benchmark::State& state) {
  const Course c = course(static_cast<int>(state.range(0)));
  NlmOptions options;
  options.calculated_points = state.range(1) != 0;
  const NlmMatcher matcher(options);
  int i = 0;
  for (auto _ : state) {
    const NlmTarget target(c.keys[i]);
    benchmark::DoNotOptimize(matcher.match(target, c.sources[i], c.starts[i]));
    i = (i + 1) % kScans;
  }
}
BENCHMARK(nlm_match)->Args({361, 0})->Args({361, 1})->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace marco::slam
