#include <gtest/gtest.h>

#include "slam/ekf/wall_filter.hpp"

namespace marco::slam {
namespace {

// A wall from `start` to `end` as an extractor states it: 1 cm of noise on some 20 points.
ObservedWall observed(const Eigen::Vector2d& start_m, const Eigen::Vector2d& end_m, int points) {
  ObservedWall wall;
  wall.start_m = start_m;
  wall.end_m = end_m;
  wall.center_m = 0.5 * (start_m + end_m);
  const Eigen::Vector2d way = end_m - start_m;
  wall.direction_rad = std::atan2(way.y(), way.x());
  wall.across_sigma_m = 0.01 / std::sqrt(points);
  wall.direction_sigma_rad = wall.across_sigma_m * std::sqrt(12.0) / way.norm();
  wall.start_sigma_m = wall.end_sigma_m = 0.03;
  wall.num_points = points;
  return wall;
}

// Ahead, 13 m away: a wall, and beyond its end a pane 5 cm behind it.
const ObservedWall kEastWall = observed({13.0, -3.0}, {13.0, 0.0}, 26);
const ObservedWall kPane = observed({13.05, 0.05}, {13.05, 0.65}, 6);
// To the side, so that the place along the wall ahead is known.
const ObservedWall kSide = observed({2.0, -3.0}, {9.0, -3.0}, 40);

// Turning made the heading unsure by 0.04 rad, half a metre out there.
WallFilter after_a_turn() {
  WallFilter filter(WallFilterOptions{}, Pose2{});
  filter.add(kEastWall);
  filter.add(kSide);
  filter.predict(Pose2{}, Eigen::Vector3d(1e-4, 1e-4, 1.6e-3).asDiagonal());
  return filter;
}

TEST(Association, WhatTheScanShowsAsTwoWallsIsNotOne) {
  const auto matches = after_a_turn().associate({kEastWall, kPane, kSide});
  EXPECT_EQ(matches[0].wall, 0);
  EXPECT_LT(matches[1].wall, 0);
  EXPECT_EQ(matches[2].wall, 1);
}

TEST(Association, AWallBesideAnotherIsNotItOnceThePoseIsKnown) {
  // In line, so that nothing across the wall speaks against it: but 1.5 m on.
  const auto matches = after_a_turn().associate({kSide, observed({13.0, 1.5}, {13.0, 2.1}, 6)});
  EXPECT_EQ(matches[0].wall, 1);
  EXPECT_LT(matches[1].wall, 0);
}

TEST(Association, AnUnsurePoseStillFindsItsWalls) {
  // Seen from a robot turned by 0.03 rad, three quarters of a sigma.
  const Pose2 turn{0.0, 0.0, -0.03};
  const auto turned = [&turn](const ObservedWall& wall, int points) {
    return observed(turn * wall.start_m, turn * wall.end_m, points);
  };
  const auto matches = after_a_turn().associate({turned(kEastWall, 26), turned(kSide, 40)});
  EXPECT_EQ(matches[0].wall, 0);
  EXPECT_EQ(matches[1].wall, 1);
}

}  // namespace
}  // namespace marco::slam
