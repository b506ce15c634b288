#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>

#include "slam/line_slam/ekf/wall_plan.hpp"
#include "slam/line_slam/line_slam.hpp"
#include "tests/support/lines_drive.hpp"
#include "tests/support/round_world.hpp"

namespace marco::slam {
namespace {

using testing::LinesDrive;
using testing::LinesLaser;
using testing::RoundWorld;

constexpr double kRadiusM = 0.075;

RoundWorld room_with_post(const Eigen::Vector2d& post_m) {
  RoundWorld world;
  world.walls.add_polygon({{0, 0}, {8, 0}, {8, 6}, {0, 6}});
  world.circles.push_back({post_m, kRadiusM});
  return world;
}

void follow(LineSlam& slam,
            const RoundWorld& world,
            const LinesLaser& laser,
            const LinesDrive& tour,
            std::mt19937& random) {
  for (std::size_t i = 0; i < tour.world_from_robot.size(); ++i) {
    const Pose2 motion = i == 0 ? Pose2{} : tour.odometry_steps[i - 1];
    slam.process(testing::round_scan(world, laser, tour.world_from_robot[i], random).scan, motion);
  }
}

TEST(LineSlamCircles, ChordsLieOnTheCircleAndFaceTheFreeSide) {
  RoundWall wall;
  wall.id = 7;
  wall.centre_m = {2.0, 1.0};
  wall.radius_m = 3.0;
  wall.from_rad = 0.5;
  wall.span_rad = 1.5;
  wall.covariance = Eigen::Vector3d(1e-4, 1e-4, 4e-4).asDiagonal();
  for (const bool from_inside : {true, false}) {
    wall.from_inside = from_inside;
    const Walls chords = chords_of(wall);
    ASSERT_GT(chords.size(), 5U);
    double length_m = 0.0;
    for (const Wall& chord : chords) {
      EXPECT_EQ(chord.id, 7);
      length_m += chord.length_m();
      const Eigen::Vector2d middle_m = 0.5 * (chord.start_m + chord.end_m);
      EXPECT_NEAR((middle_m - wall.centre_m).norm(), 3.0, 0.0011);
      const Eigen::Vector2d left = turned_left(chord.end_m - chord.start_m);
      EXPECT_EQ(left.dot(wall.centre_m - middle_m) > 0.0, from_inside);
      // Outwards: the centre's and the radius' variances; along the wall the centre's alone.
      const Eigen::Vector2d out = (chord.start_m - wall.centre_m).normalized();
      const Eigen::Matrix2d of_start = chord.covariance.topLeftCorner<2, 2>();
      EXPECT_NEAR(out.dot(of_start * out), 5e-4, 1e-9);
      EXPECT_NEAR(turned_left(out).dot(of_start * turned_left(out)), 1e-4, 1e-9);
    }
    EXPECT_NEAR(length_m, 3.0 * 1.5, 0.01);
  }
}

TEST(LineSlamCircles, APostIsKnownToMillimetresAfterTwoMetres) {
  constexpr int kRuns = 60;
  int found = 0, invented = 0;
  double nees = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> along(3.0, 5.0), off(1.2, 2.5);
    const Eigen::Vector2d post_m(along(random), 1.5 + off(random));
    const RoundWorld world = room_with_post(post_m);
    const LinesDrive tour = testing::drive({{2.5, 1.5}, {4.5, 1.5}}, 2.0 / 29.0, 0.1, {}, random);
    ASSERT_EQ(tour.world_from_robot.size(), 30U);
    LineSlam slam{LineSlamOptions{}, tour.world_from_robot[0]};
    follow(slam, world, LinesLaser{}, tour, random);
    for (const RoundWall& wall : slam.map().round_walls) {
      Eigen::Vector3d error;
      error << wall.centre_m - post_m, wall.radius_m - kRadiusM;
      if (error.head<2>().norm() > 0.2) {
        ++invented;
        continue;
      }
      found += error.head<2>().norm() <= 0.01 && std::abs(error.z()) <= 0.005 ? 1 : 0;
      nees += error.dot(wall.covariance.ldlt().solve(error)) / 3.0 / kRuns;
    }
  }
  std::printf("within 1 cm and 5 mm: %d of %d, NEES %.2f\n", found, kRuns, nees);
  EXPECT_GE(found, 0.95 * kRuns);
  EXPECT_EQ(invented, 0);
  // This laser's spots are points, which the filter cannot know: it says too much, not too little.
  EXPECT_GT(nees, 0.05);
  EXPECT_LT(nees, 1.2);
}

// In a round room nothing but posts tells the heading. A path whose poses are each off by 1 cm and
// half a degree knows a post by the mean of all, not by the first ones.
TEST(LineSlamCircles, AlongAGivenPathEachPoseHasItsSay) {
  constexpr int kRuns = 20, kPoses = 60;
  constexpr double kPoseSigmaM = 0.01, kPoseSigmaRad = 0.009;
  const Eigen::Vector2d post_m(1.5, 1.0);
  RoundWorld world;
  world.circles = {{{0, 0}, 4.0, true}, {post_m, 0.1}};
  LinesLaser laser;
  laser.beams = 720;
  laser.first_rad = -std::numbers::pi;
  const Eigen::Matrix3d covariance =
      Eigen::Vector3d(kPoseSigmaM * kPoseSigmaM, kPoseSigmaM * kPoseSigmaM,
                      kPoseSigmaRad * kPoseSigmaRad)
          .asDiagonal();
  int known = 0;
  double nees = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    LineSlam slam{LineSlamOptions{}};
    for (int i = 0; i < kPoses; ++i) {
      const double angle = 0.1 * i;
      const Pose2 truth{-0.6 + 1.2 * std::cos(angle), -0.6 + 1.2 * std::sin(angle), 0.3 * i};
      const Pose2 given{truth.x_m + kPoseSigmaM * normal(random),
                        truth.y_m + kPoseSigmaM * normal(random),
                        normalize_angle(truth.theta_rad + kPoseSigmaRad * normal(random))};
      slam.process_at(testing::round_scan(world, laser, truth, random).scan, given, covariance);
    }
    for (const RoundWall& wall : slam.map().round_walls) {
      if (wall.from_inside || (wall.centre_m - post_m).norm() > 0.3) continue;
      Eigen::Vector3d error;
      error << wall.centre_m - post_m, wall.radius_m - 0.1;
      known += error.head<2>().norm() <= 0.01 && std::abs(error.z()) <= 0.005 ? 1 : 0;
      nees += error.dot(wall.covariance.ldlt().solve(error)) / 3.0 / kRuns;
    }
  }
  std::printf("within 1 cm and 5 mm: %d of %d, NEES %.2f\n", known, kRuns, nees);
  EXPECT_GE(known, 0.95 * kRuns);
  EXPECT_GT(nees, 0.1);
  EXPECT_LT(nees, 1.6);
}

TEST(LineSlamCircles, APostThatWasTakenAwayIsForgotten) {
  std::mt19937 random(31);
  RoundWorld world = room_with_post({3.5, 3.2});
  const LinesDrive tour = testing::drive({{2.5, 1.5}, {4.5, 1.5}}, 0.06, 0.1, {}, random);
  LineSlam slam{LineSlamOptions{}, tour.world_from_robot[0]};
  follow(slam, world, LinesLaser{}, tour, random);
  ASSERT_EQ(slam.map().round_walls.size(), 1U);
  world.circles.clear();
  for (int i = 0; i < 20; ++i) {
    // Each look is a step: it turns to and fro.
    const Pose2 turn{0.0, 0.0, (i % 2 == 0 ? 1.0 : -1.0) * deg_to_rad(40.0)};
    const Pose2 at = tour.world_from_robot.back() * (i % 2 == 0 ? turn : Pose2{});
    slam.process(testing::round_scan(world, LinesLaser{}, at, random).scan, turn);
  }
  EXPECT_TRUE(slam.map().round_walls.empty());
}

RoundWall post(double x_m, double y_m, double radius_m) {
  RoundWall post;
  post.centre_m = {x_m, y_m};
  post.radius_m = radius_m;
  return post;
}

TEST(LineSlamCircles, WhatAWallRunsThroughIsNoPost) {
  Wall front;
  front.start_m = {1.0, 2.0};
  front.end_m = {2.1, 2.0};
  // Through it; past the wall's end; beside the wall; too wide for a post.
  RoundWalls posts{post(1.8, 2.18, 0.29), post(2.3, 2.0, 0.29), post(1.5, 2.25, 0.25),
                   post(1.5, 2.0, 0.6)};
  drop_posts_on_walls({front}, posts);
  ASSERT_EQ(posts.size(), 3U);
  EXPECT_EQ(posts[0].centre_m.x(), 2.3);
}

// It hides the wall behind it.
TEST(LineSlamCircles, AColumnThatSticksOutOfAWallIsAPost) {
  std::mt19937 random(33);
  RoundWorld world;
  world.walls.add_polygon({{0, 0}, {8, 0}, {8, 6}, {0, 6}});
  world.circles.push_back({{3.5, 0.0}, 0.3});
  const LinesDrive tour =
      testing::drive({{1.5, 2.0}, {5.5, 2.0}, {1.5, 2.5}}, 0.06, 0.1, {}, random);
  LineSlam slam{LineSlamOptions{}, tour.world_from_robot[0]};
  follow(slam, world, LinesLaser{}, tour, random);
  const LineMap map = slam.map();
  ASSERT_EQ(map.round_walls.size(), 1U);
  EXPECT_NEAR(map.round_walls[0].radius_m, 0.3, 0.01);
}

TEST(LineSlamCircles, ARoundRoomIsOneArcAndNoWalls) {
  std::mt19937 random(32);
  RoundWorld world;
  world.circles = {{{0, 0}, 4.0, true}, {{1.5, 1.5}, 0.2}, {{-1.6, 0.3}, 0.3}};
  LinesLaser laser;
  laser.beams = 720;
  laser.first_rad = -std::numbers::pi;
  const LinesDrive tour =
      testing::drive({{-1, -2}, {1.5, -1.5}, {2.5, 1.0}, {0, 1.5}}, 0.08, 0.1, {}, random);
  LineSlam slam{LineSlamOptions{}, tour.world_from_robot[0]};
  follow(slam, world, laser, tour, random);
  EXPECT_TRUE(slam.plan().empty());
  int rooms = 0, columns = 0;
  for (const RoundWall& wall : slam.map().round_walls) {
    if (!wall.from_inside) {
      ++columns;
      continue;
    }
    ++rooms;
    EXPECT_LT(wall.centre_m.norm(), 0.03);
    EXPECT_NEAR(wall.radius_m, 4.0, 0.01);
    EXPECT_TRUE(wall.is_whole());
  }
  EXPECT_EQ(rooms, 1);
  EXPECT_EQ(columns, 2);
}

TEST(LineSlamCircles, ARestoredFilterGoesOnBitForBit) {
  std::mt19937 random(33);
  const RoundWorld world = room_with_post({3.5, 3.2});
  const LinesDrive tour = testing::drive({{2.5, 1.5}, {4.5, 1.5}}, 0.06, 0.1, {}, random);
  LineSlam slam{LineSlamOptions{}, tour.world_from_robot[0]};
  follow(slam, world, LinesLaser{}, tour, random);
  LineSlam restored{LineSlamOptions{}};
  restored.restore(slam.store());
  std::mt19937 again = random;
  follow(slam, world, LinesLaser{}, tour, random);
  follow(restored, world, LinesLaser{}, tour, again);
  ASSERT_EQ(slam.map().round_walls.size(), restored.map().round_walls.size());
  ASSERT_FALSE(slam.map().round_walls.empty());
  EXPECT_EQ(slam.map().round_walls[0].centre_m, restored.map().round_walls[0].centre_m);
  EXPECT_EQ(slam.map().round_walls[0].covariance, restored.map().round_walls[0].covariance);
}

}  // namespace
}  // namespace marco::slam
