#include <benchmark/benchmark.h>
#include <time.h>

#include <Eigen/LU>
#include <algorithm>
#include <random>

#include "slam/line_slam/ekf/wall_filter.hpp"
#include "slam/line_slam/lines/line_extractor.hpp"
#include "tests/support/lines_dense_state.hpp"
#include "tests/support/lines_world.hpp"

namespace marco::slam {
namespace {

using testing::LinesWorld;

void extract_scan(benchmark::State& state) {
  const LinesWorld world = testing::make_loop_world();
  testing::LinesLaser laser;
  laser.outlier_part = static_cast<double>(state.range(0)) / 100.0;
  std::mt19937 random(1);
  std::vector<ScanInRobot> scans;
  for (int i = 0; i < 50; ++i) {
    scans.push_back(testing::take_scan(world, laser, {1.5 + 0.1 * i, 1.5, 0.12 * i}, random).scan);
  }
  LineExtractor extractor{LineExtractorOptions{}};
  std::size_t at = 0, walls = 0;
  for (auto _ : state) walls += extractor.extract(scans[at++ % scans.size()]).size();
  state.counters["walls"] = static_cast<double>(walls) / static_cast<double>(state.iterations());
}
BENCHMARK(extract_scan)->Arg(0)->Arg(10)->Unit(benchmark::kMicrosecond);

// A long corridor of rooms: 12 walls around the robot wherever it is, `count` in all.
class Corridor {
 public:
  explicit Corridor(int count) : count_(count) {}

  // The six nearest pairs of walls, seen from `x_m`, which is exact: the filter's work is the same.
  std::vector<ObservedWall> seen_from(const Pose2& robot, std::mt19937& random) const {
    std::normal_distribution<double> noise(0.0, 0.003);
    std::vector<ObservedWall> seen;
    const int first = std::clamp(static_cast<int>(robot.x_m / 2.0) - 3, 0, count_ / 2 - 6);
    for (int k = first; k < first + 6; ++k) {
      for (const double side : {1.0, -1.0}) {
        ObservedWall wall;
        // Every other wall slants, always the same side to the robot; ends tell the place along.
        const double x = 2.0 * k + 0.5, y = 2.0 * side;
        const Eigen::Vector2d a = robot.inverse() * Eigen::Vector2d(x, y);
        const Eigen::Vector2d b =
            robot.inverse() * Eigen::Vector2d(x + 1.0, k % 2 == 0 ? y : 1.1 * y);
        const bool turned = a.x() * b.y() - a.y() * b.x() < 0.0;
        wall.start_m = turned ? b : a;
        wall.end_m = turned ? a : b;
        const Eigen::Vector2d way = wall.end_m - wall.start_m;
        wall.direction_rad = std::atan2(way.y(), way.x());
        const Eigen::Vector2d shift = noise(random) * wall.across();
        wall.start_m += shift;
        wall.end_m += shift;
        wall.center_m = 0.5 * (wall.start_m + wall.end_m);
        wall.across_sigma_m = 0.003;
        wall.direction_sigma_rad = 0.003;
        wall.start_sigma_m = wall.end_sigma_m = 0.02;
        wall.start_seen = wall.end_seen = true;
        wall.num_points = 20;
        seen.push_back(wall);
      }
    }
    return seen;
  }
  double length_m() const { return static_cast<double>(count_); }

 private:
  int count_;
};

WallFilter mapped(const Corridor& corridor, std::mt19937& random) {
  WallFilterOptions options;
  // Odometry is exact here; what the filter believes of it must keep a kilometre's walls apart.
  options.motion.distance_sigma_part = 0.01;
  options.motion.heading_sigma_part = 0.01;
  options.motion.heading_sigma_rad_per_m = 0.001;
  options.motion.floor_m = 0.001;
  options.motion.floor_rad = 0.0005;
  WallFilter filter(options, {1.0, 0.0, 0.0});
  for (double x = 1.0; x < corridor.length_m() - 1.0; x += 1.0) {
    filter.predict(x == 1.0 ? Pose2{} : Pose2{1.0, 0.0, 0.0});
    const auto seen = corridor.seen_from({x, 0.0, 0.0}, random);
    auto matches = filter.associate(seen);
    filter.correct(seen, matches);
    filter.add_new(seen, matches);
  }
  return filter;
}

// Processor time of this thread: what others do on the machine does not count.
double thread_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// One step of the filter: predict, focus, associate, correct. The robot drives through the whole
// map, so that other walls come near on the way.
void filter_step(benchmark::State& state) {
  const Corridor corridor(static_cast<int>(state.range(0)));
  std::mt19937 random(2);
  WallFilter filter = mapped(corridor, random);
  double x = corridor.length_m() - 2.0, direction = -1.0;  // where mapping ended
  std::vector<double> times_ms;
  double matched = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    if (x < 2.0) direction = 1.0;
    if (x > corridor.length_m() - 2.0) direction = -1.0;
    x += 0.1 * direction;
    const auto seen = corridor.seen_from({x, 0.0, 0.0}, random);
    state.ResumeTiming();
    const double begin_ms = thread_ms();
    filter.predict({0.1 * direction, 0.0, 0.0});
    const auto matches = filter.associate(seen);
    filter.correct(seen, matches);
    times_ms.push_back(thread_ms() - begin_ms);
    for (const WallMatch& match : matches) matched += match.wall >= 0 ? 1.0 : 0.0;
  }
  std::sort(times_ms.begin(), times_ms.end());
  state.counters["median_ms"] = times_ms[times_ms.size() / 2];
  state.counters["worst_ms"] = times_ms.back();
  state.counters["walls"] = static_cast<double>(filter.num_walls());
  state.counters["matched"] = matched / static_cast<double>(state.iterations());
}
BENCHMARK(filter_step)->Arg(200)->Arg(1300)->Iterations(2000)->Unit(benchmark::kMillisecond);

// The textbook's step: all measurements in one H, full matrices, one inverse.
void textbook_step(benchmark::State& state) {
  const int walls = static_cast<int>(state.range(0));
  const Eigen::Index n = 3 + 4 * walls, m = 4 * 12;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd p = Eigen::MatrixXd::Identity(n, n) * 0.01;
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(m, n);
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) h(i, j) = normal(random);
    for (Eigen::Index j = 0; j < 4; ++j) h(i, 3 + 4 * (i / 4) + j) = normal(random);
  }
  const Eigen::MatrixXd r = Eigen::MatrixXd::Identity(m, m) * 1e-4;
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd f = identity;
  f(0, 2) = 0.1;
  for (auto _ : state) {
    p = f * p * f.transpose();
    const Eigen::MatrixXd s = h * p * h.transpose() + r;
    const Eigen::MatrixXd gain = p * h.transpose() * s.inverse();
    p = (identity - gain * h) * p * (identity - gain * h).transpose() + gain * r * gain.transpose();
    benchmark::DoNotOptimize(p.data());
  }
}
BENCHMARK(textbook_step)->Arg(200)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace marco::slam
