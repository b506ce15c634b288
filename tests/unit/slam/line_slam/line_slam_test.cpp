#include "slam/line_slam/line_slam.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/support/lines_drive.hpp"
#include "tests/support/lines_world.hpp"
#include "tests/support/slow_matrices.hpp"

namespace marco::slam {
namespace {

using testing::LinesDrive;
using testing::LinesLaser;
using testing::LinesWorld;

const std::vector<Eigen::Vector2d> kLoop = {{1.5, 1.5},  {4.5, 1.5},  {7.0, 2.0},
                                            {12.5, 1.5}, {12.5, 8.5}, {7.0, 8.0},
                                            {1.8, 8.5},  {1.8, 1.6},  {4.5, 1.4}};

// Distance of the farthest of nine points along a wall from the nearest edge of the world.
double farthest_from_world_m(const Wall& wall, const LinesWorld& world) {
  double farthest = 0.0;
  for (int k = 0; k <= 8; ++k) {
    const Eigen::Vector2d point = wall.start_m + k / 8.0 * (wall.end_m - wall.start_m);
    double nearest = 1e9;
    for (const LinesWorld::Edge& edge : world.edges) {
      const Eigen::Vector2d way = edge.end_m - edge.start_m;
      const double part = std::clamp((point - edge.start_m).dot(way) / way.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (point - edge.start_m - part * way).norm());
    }
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

struct LoopResult {
  double rms_m = 0.0, odometry_rms_m = 0.0, mean_nees = 0.0;
};

LoopResult follow_loop(unsigned seed,
                       const LineSlamOptions& options = {},
                       LineSlam* kept = nullptr) {
  const LinesWorld world = testing::make_loop_world();
  std::mt19937 random(seed);
  const LinesDrive tour = testing::drive(kLoop, 0.1, 0.1, {}, random);
  // The first pose is off by what the filter says of it.
  std::mt19937 start_random(seed + 100000U);
  std::normal_distribution<double> normal;
  const Pose2& start = tour.world_from_robot[0];
  LineSlam slam(options, {start.x_m + options.filter.start_sigma_m * normal(start_random),
                          start.y_m + options.filter.start_sigma_m * normal(start_random),
                          start.theta_rad + options.filter.start_sigma_rad * normal(start_random)});
  Pose2 odometry = tour.world_from_robot[0];
  LoopResult result;
  const auto steps = static_cast<double>(tour.world_from_robot.size());
  for (std::size_t i = 0; i < tour.world_from_robot.size(); ++i) {
    const Pose2 motion = i == 0 ? Pose2{} : tour.odometry_steps[i - 1];
    odometry = odometry * motion;
    const Pose2& truth = tour.world_from_robot[i];
    const auto taken = testing::take_scan(world, LinesLaser{}, truth, random);
    const LineSlamUpdate update = slam.process(taken.scan, motion);
    Eigen::Vector3d error = update.world_from_robot.vector() - truth.vector();
    error.z() = normalize_angle(error.z());
    result.rms_m += error.head<2>().squaredNorm() / steps;
    result.mean_nees += testing::distance2(error, update.covariance) / steps;
    result.odometry_rms_m +=
        (odometry.translation_m() - truth.translation_m()).squaredNorm() / steps;
  }
  result.rms_m = std::sqrt(result.rms_m);
  result.odometry_rms_m = std::sqrt(result.odometry_rms_m);
  if (kept != nullptr) *kept = std::move(slam);
  return result;
}

TEST(LineSlam, FollowsALoopAndDrawsItsWalls) {
  LineSlam slam{LineSlamOptions{}};
  const LoopResult result = follow_loop(11, {}, &slam);
  EXPECT_LT(result.rms_m, 0.1 * result.odometry_rms_m);
  const Walls plan = slam.plan();
  EXPECT_GE(plan.size(), 15U);
  // Three sigma of the worst known end, and some centimetres that the pose wandered.
  for (const Wall& wall : plan) {
    const double sigma_m = std::sqrt(wall.covariance.diagonal().maxCoeff());
    EXPECT_LT(farthest_from_world_m(wall, testing::make_loop_world()), 0.05 + 3.0 * sigma_m)
        << wall.id;
  }
}

double mean_nees(const LineSlamOptions& options, int runs) {
  double nees = 0.0;
  for (int run = 0; run < runs; ++run) {
    nees += follow_loop(2000U + static_cast<unsigned>(run), options).mean_nees / runs;
  }
  return nees;
}

// Extracted walls and the filter's own associations, with the noise of this drive in the options:
// the average NEES lies in the 95 % band of a printed table. Steps of one run are correlated, so
// the band is that of one independent value per run.
LineSlamOptions options_of_this_drive() {
  LineSlamOptions options;
  options.filter.motion = {0.03, 0.0, 0.03, 0.01, 0.001, 0.0005};
  options.filter.across_floor_m = 0.0;
  options.filter.direction_floor_rad = 0.0;
  options.filter.start_sigma_m = 0.01;
  options.filter.start_sigma_rad = 0.005;
  return options;
}

// Corners of walls as they are known together. Their errors share the start's and the path's, so
// that one run counts as one value.
TEST(LineSlam, CornersLieWhereTheirCovarianceSays) {
  const LinesWorld world = testing::make_loop_world();
  constexpr int kRuns = 12;
  double nees = 0.0;
  std::size_t found = 0, wrong = 0;
  for (int run = 0; run < kRuns; ++run) {
    LineSlam slam{LineSlamOptions{}};
    follow_loop(3000U + static_cast<unsigned>(run), options_of_this_drive(), &slam);
    const CornerPoints corners = slam.map().corners;
    for (const CornerPoint& corner : corners) {
      Eigen::Vector2d nearest(1e9, 1e9);
      for (const LinesWorld::Edge& edge : world.edges) {
        const Eigen::Vector2d off = corner.at_m - edge.start_m;
        if (off.norm() < nearest.norm()) nearest = off;
      }
      wrong += nearest.norm() > 0.25 ? 1 : 0;
      if (nearest.norm() > 0.25) continue;
      ++found;
      nees += nearest.dot(corner.covariance.ldlt().solve(nearest)) / 2.0;
    }
  }
  std::printf("%zu corners, %zu wrong, NEES %.2f\n", found, wrong,
              nees / static_cast<double>(found));
  EXPECT_GE(found, 12U * kRuns);
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(nees / static_cast<double>(found), 0.5);
  EXPECT_LT(nees / static_cast<double>(found), 1.6);
}

TEST(LineSlam, NeesOfItsOwnAssociationsLiesInItsBand) {
  const double nees = mean_nees(options_of_this_drive(), 10);
  EXPECT_GE(nees, 16.791 / 10) << "30 degrees of freedom";
  EXPECT_LE(nees, 46.979 / 10);
}

TEST(LineSlam, DISABLED_NeesOverAHundredRunsLiesInItsBand) {
  const double nees = mean_nees(options_of_this_drive(), 100);
  EXPECT_GE(nees, 253.912 / 100) << "300 degrees of freedom";
  EXPECT_LE(nees, 349.874 / 100);
}

// The defaults are for wheels one knows nothing of: never overconfident, and within a factor of ten
// of the true variance.
TEST(LineSlam, TheDefaultsAreConservative) {
  const double nees = mean_nees({}, 10);
  EXPECT_GE(nees, 0.3);
  EXPECT_LE(nees, 3.0);
}

// A room divided by a wall with three doors; some shut, then opened, and the reverse.
LinesWorld room_with_doors(const std::vector<bool>& is_open) {
  LinesWorld world;
  world.add_polygon({{0, 0}, {12, 0}, {12, 8}, {0, 8}});
  double x = 0.0;
  for (std::size_t door = 0; door <= is_open.size(); ++door) {
    const double to = door < is_open.size() ? 2.0 + 3.5 * static_cast<double>(door) : 12.0;
    world.edges.push_back({{to, 4.0}, {x, 4.0}});
    if (door < is_open.size() && !is_open[door]) {
      world.edges.push_back({{to + 1.0, 4.0}, {to, 4.0}});
    }
    x = to + 1.0;
  }
  return world;
}

TEST(LineSlam, DoorsThatChangeAndPeopleLeaveNoGhosts) {
  std::mt19937 random(21);
  const std::vector<Eigen::Vector2d> way = {
      {1.5, 2.0}, {10.5, 2.0}, {1.5, 2.2}, {10.5, 1.8}, {1.5, 2.0}};
  const LinesDrive tour = testing::drive(way, 0.1, 0.15, {}, random);
  LineSlam slam(LineSlamOptions{}, tour.world_from_robot[0]);
  const LinesWorld before = room_with_doors({false, true, false});
  const LinesWorld after = room_with_doors({true, false, true});
  for (std::size_t i = 0; i < tour.world_from_robot.size(); ++i) {
    LinesWorld now = i < tour.world_from_robot.size() / 2 ? before : after;
    for (int person = 0; person < 10; ++person) {  // boxes of 0.5 m x 0.3 m, each on its way
      const double t = 0.05 * static_cast<double>(i) + 1.3 * person;
      const double x = 6.0 + 5.0 * std::sin(0.7 * t + person);
      const double y = 0.8 + 0.25 * person + 0.3 * std::cos(t);
      const Eigen::Vector2d robot = tour.world_from_robot[i].translation_m();
      if (y > 3.4 || (Eigen::Vector2d(x, y) - robot).norm() < 0.8) continue;
      now.add_box(x, y, x + 0.5, y + 0.3);
    }
    const auto taken = testing::take_scan(now, LinesLaser{}, tour.world_from_robot[i], random);
    slam.process(taken.scan, i == 0 ? Pose2{} : tour.odometry_steps[i - 1]);
  }
  const Walls plan = slam.plan();
  for (const Wall& wall : plan) {
    EXPECT_LT(farthest_from_world_m(wall, after), 0.15)
        << "ghost (" << wall.start_m.transpose() << ")-(" << wall.end_m.transpose() << ") seen "
        << wall.times_seen;
  }
  const auto stands_at = [&](double x) {
    return std::any_of(plan.begin(), plan.end(), [x](const Wall& wall) {
      return std::abs(wall.start_m.y() - 4.0) < 0.2 && std::abs(wall.end_m.y() - 4.0) < 0.2 &&
             std::min(wall.start_m.x(), wall.end_m.x()) < x &&
             std::max(wall.start_m.x(), wall.end_m.x()) > x;
    });
  };
  EXPECT_FALSE(stands_at(2.5)) << "the first door is open now";
  EXPECT_TRUE(stands_at(6.0)) << "the second is shut";
  EXPECT_FALSE(stands_at(9.5)) << "the third is open";
  EXPECT_TRUE(stands_at(1.0));
  EXPECT_TRUE(stands_at(4.2));
}

}  // namespace
}  // namespace marco::slam
