#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "tests/support/lines_known.hpp"
#include "tests/support/slow_matrices.hpp"

namespace marco::slam {
namespace {

const std::vector<Eigen::Vector2d> kLoop = {{1.5, 1.5}, {7.0, 2.0}, {12.5, 1.5}, {12.5, 8.5},
                                            {7.0, 8.0}, {1.8, 8.5}, {1.8, 1.6},  {4.5, 1.4}};

WallFilterOptions exact_options() {
  WallFilterOptions options;
  options.across_floor_m = 0.0;
  options.direction_floor_rad = 0.0;
  options.start_sigma_m = 0.01;
  options.start_sigma_rad = 0.005;
  options.new_wall_length_m = 0.0;
  options.motion.distance_sigma_part = 0.05;
  options.new_wall_points = 3;
  options.motion.heading_sigma_part = 0.05;
  options.motion.heading_sigma_rad_per_m = 0.02;
  options.motion.floor_m = 0.002;
  options.motion.floor_rad = 0.001;
  options.end_distance_m = 10.0;  // associations are known: no end is another wall's
  options.max_end_distance_m = 10.0;
  return options;
}

// Mean NEES of the pose over all steps of `runs` runs; 3 for a filter that knows what it does not
// know. Steps of one run are correlated, so the band is taken as for one independent value a run
// and step mean: runs * 3 degrees of freedom.
double mean_nees(int runs) {
  double sum = 0.0;
  int count = 0;
  for (int run = 0; run < runs; ++run) {
    testing::LinesKnownRun known(exact_options(), testing::make_loop_world(),
                                 1000U + static_cast<unsigned>(run));
    known.run(kLoop, [&](const WallFilter& filter, const Pose2& truth, bool) {
      Eigen::Vector3d error = filter.world_from_robot().vector() - truth.vector();
      error.z() = normalize_angle(error.z());
      sum += testing::distance2(error, filter.robot_covariance());
      ++count;
    });
  }
  return sum / count;
}

/// The 95 % band of a sum over so many runs: chi-square quantiles from a printed table.
struct Band {
  int runs;
  double low, high;
};

void expect_in_band(const Band& band) {
  const int runs = band.runs;
  const double nees = mean_nees(runs);
  const double low = band.low / runs, high = band.high / runs;
  std::printf("%d runs, known associations: mean NEES %.3f, 95 %% band [%.3f, %.3f]\n", runs, nees,
              low, high);
  EXPECT_GE(nees, low);
  EXPECT_LE(nees, high);
}

TEST(Consistency, NeesOverTwentyRunsLiesInItsBand) {
  expect_in_band({20, 40.482, 83.298});  // 60 degrees of freedom
}

// The long version, by --gtest_also_run_disabled_tests (ctest label `long`).
TEST(Consistency, DISABLED_NeesOverAHundredRunsLiesInItsBand) {
  expect_in_band({100, 253.912, 349.874});  // 300 degrees of freedom
}

double smaller_eigenvalue(const Eigen::Matrix2d& p) {
  return 0.5 * (p(0, 0) + p(1, 1)) - std::hypot(0.5 * (p(0, 0) - p(1, 1)), p(0, 1));
}

// (5.43-5.45)
TEST(Convergence, WhatAnExtendedKalmanFilterForMapsMustShow) {
  const WallFilterOptions options = exact_options();
  testing::LinesKnownRun known(options, testing::make_loop_world(), 5);
  double last_log_det = 0.0, least_heading_ratio = 1e9, least_position_ratio = 1e9;
  Eigen::Index last_size = 0;
  int grown = 0, compared = 0;
  double relative_first = 0.0, relative_last = 0.0;
  known.run(kLoop, [&](WallFilter& filter, const Pose2&, bool added) {
    const Eigen::MatrixXd p = filter.state().dense_covariance(filter.blocks());
    const Eigen::MatrixXd walls = p.bottomRightCorner(p.rows() - 3, p.cols() - 3);
    const double log_det = testing::log_determinant(walls);
    if (!added && walls.rows() == last_size) {
      ++compared;
      // The sum of some 80 logarithms of numbers near 1e-5 is good to 1e-9 or so.
      if (log_det > last_log_det + 1e-7) ++grown;
    }
    last_log_det = log_det;
    last_size = walls.rows();
    const double start2 = options.start_sigma_rad * options.start_sigma_rad;
    least_heading_ratio = std::min(least_heading_ratio, p(2, 2) / start2);
    least_position_ratio =
        std::min(least_position_ratio, smaller_eigenvalue(p.topLeftCorner<2, 2>()) /
                                           (options.start_sigma_m * options.start_sigma_m));
    // Distance of the first wall's start from the second wall's: turning the whole map by the
    // heading's error, which stays, does not change it.
    const Eigen::Vector2d way =
        (filter.wall_mean(1).head<2>() - filter.wall_mean(0).head<2>()).normalized();
    const Eigen::Matrix2d relative =
        p.block<2, 2>(3, 3) + p.block<2, 2>(7, 7) - p.block<2, 2>(3, 7) - p.block<2, 2>(7, 3);
    const double variance = way.dot(relative * way);
    if (relative_first == 0.0) relative_first = variance;
    relative_last = variance;
  });
  EXPECT_GT(compared, 50);
  EXPECT_EQ(grown, 0) << "(5.43): det P_l grew without a wall added";
  EXPECT_LT(relative_last, 0.1 * relative_first) << "(5.44): walls must become fully correlated";
  // (5.45): never surer of the heading than at the start, less what linearization takes (measured:
  // a plain filter falls to about 0.5).
  EXPECT_GT(least_heading_ratio, 0.97);
  EXPECT_GT(least_position_ratio, 0.9);
  std::printf("least heading variance %.3f, position %.3f of the start's\n", least_heading_ratio,
              least_position_ratio);
}

}  // namespace
}  // namespace marco::slam
