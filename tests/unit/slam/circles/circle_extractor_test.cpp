#include "slam/line_slam/circles/circle_extractor.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "tests/support/round_world.hpp"

namespace marco::slam {
namespace {

using testing::RoundWorld;

constexpr double kFarthestM = 20.0;

// A post before a far wall, off the sensor by up to a beam.
TEST(CircleExtractor, APostIsAsWellKnownAsItsRangesAllow) {
  constexpr double kRadiusM = 0.075;
  std::mt19937 random(21);
  std::uniform_real_distribution<double> heading(-1.0, 1.0);
  for (const double far_m : {0.8, 1.5, 2.5, 4.0}) {
    constexpr int kScans = 300;
    double squares = 0.0, bound = 0.0, nees = 0.0;
    int found = 0;
    CircleExtractor extractor;
    for (int i = 0; i < kScans; ++i) {
      RoundWorld world;
      world.walls.add_polygon({{-3, -8}, {9, -8}, {9, 8}, {-3, 8}});
      const double at = heading(random);
      const Eigen::Vector2d post_m(far_m * std::cos(at), far_m * std::sin(at));
      world.circles.push_back({post_m, kRadiusM});
      const auto seen = testing::round_scan(world, testing::LinesLaser{}, {}, random);
      const Eigen::Matrix3d fisher = testing::fisher_of(seen, world.circles[0], 0, 0.01);
      for (const ObservedCircle& circle : extractor.extract(seen.scan, kFarthestM)) {
        EXPECT_LT((circle.centre_m - post_m).norm(), 0.3);
        if ((circle.centre_m - post_m).norm() > 0.3 || fisher.determinant() < 1e3) continue;
        ++found;
        Eigen::Vector3d error;
        error << circle.centre_m - post_m, circle.radius_m - kRadiusM;
        squares += error.head<2>().squaredNorm();
        bound += fisher.inverse().topLeftCorner<2, 2>().trace();
        nees += error.dot(circle.covariance.ldlt().solve(error)) / 3.0;
      }
    }
    std::printf("%.1f m: found %d of %d, error / bound %.2f, NEES %.2f\n", far_m, found, kScans,
                std::sqrt(squares / bound), nees / found);
    // Of the four beams that meet it at 4 m, some leave the radius open.
    EXPECT_GE(found, (far_m < 3.0 ? 0.9 : 0.7) * kScans) << far_m;
    EXPECT_LT(std::sqrt(squares / bound), 1.5) << far_m;
    EXPECT_GT(nees / found, 0.5) << far_m;
    EXPECT_LT(nees / found, 1.2) << far_m;
  }
}

TEST(CircleExtractor, ARoundRoomIsOneCircleAndItsColumnsAreFound) {
  std::mt19937 random(22);
  RoundWorld world;
  world.circles = {{{0, 0}, 4.0, true}, {{1.5, 1.0}, 0.2}, {{-1.5, 0.5}, 0.075}};
  testing::LinesLaser laser;
  laser.beams = 720;
  laser.first_rad = -3.1;
  CircleExtractor extractor;
  int columns = 0, rooms = 0;
  for (int i = 0; i < 20; ++i) {
    const auto seen = testing::round_scan(world, laser, {0.3, -0.8, 0.3 * i}, random);
    const Pose2 pose{0.3, -0.8, 0.3 * i};
    for (const ObservedCircle& circle : extractor.extract(seen.scan, kFarthestM)) {
      if (!circle.clear) continue;
      const Eigen::Vector2d centre_m = pose * circle.centre_m;
      if (circle.from_inside) {
        ++rooms;
        Eigen::Vector3d error;
        error << pose.rotation().transpose() * centre_m, circle.radius_m - 4.0;
        EXPECT_LT(error.dot(circle.covariance.ldlt().solve(error)), 16.3);  // once in 1000
      } else {
        ++columns;
        EXPECT_LT(std::min((centre_m - world.circles[1].centre_m).norm(),
                           (centre_m - world.circles[2].centre_m).norm()),
                  0.04);
      }
    }
  }
  EXPECT_GE(columns, 20);
  EXPECT_GE(rooms, 40);  // the columns hide parts of it
}

TEST(CircleExtractor, WallsAndCornersAreNoCircles) {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> x(0.4, 13.6), y(0.4, 9.6), heading(-3.1, 3.1);
  RoundWorld world;
  world.walls = testing::make_loop_world();
  CircleExtractor extractor;
  int clear = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pose2 pose{x(random), y(random), heading(random)};
    const auto seen = testing::round_scan(world, testing::LinesLaser{}, pose, random);
    for (const ObservedCircle& circle : extractor.extract(seen.scan, kFarthestM)) {
      clear += circle.clear ? 1 : 0;
    }
  }
  EXPECT_EQ(clear, 0);
}

// A table's leg of 5 cm square is no post, however it is turned.
TEST(CircleExtractor, ASquareLegIsNoPost) {
  std::mt19937 random(24);
  std::uniform_real_distribution<double> turn(0.0, 1.57);
  CircleExtractor extractor;
  int clear = 0;
  for (int i = 0; i < 400; ++i) {
    RoundWorld world;
    world.walls.add_polygon({{-3, -8}, {9, -8}, {9, 8}, {-3, 8}});
    const Pose2 leg{1.0 + 0.005 * i, 0.1, turn(random)};
    world.walls.add_polygon(
        {leg * Eigen::Vector2d(-0.025, -0.025), leg * Eigen::Vector2d(-0.025, 0.025),
         leg * Eigen::Vector2d(0.025, 0.025), leg * Eigen::Vector2d(0.025, -0.025)});
    const auto seen = testing::round_scan(world, testing::LinesLaser{}, {}, random);
    for (const ObservedCircle& circle : extractor.extract(seen.scan, kFarthestM)) {
      clear += circle.clear ? 1 : 0;
    }
  }
  std::printf("%d of 400 legs\n", clear);
  EXPECT_LE(clear, 4);
}

}  // namespace
}  // namespace marco::slam
