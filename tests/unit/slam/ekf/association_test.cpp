#include <gtest/gtest.h>

#include "slam/line_slam/ekf/wall_filter.hpp"
#include "tests/support/lines_information_state.hpp"

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

// Two parts of one wall, joined, against a filter that rebuilds its covariance from all information
// there ever was; the measurement "both lie on one line" by central differences.
TEST(Joining, EqualsAFilterRebuiltFromTheInformation) {
  const WallFilterOptions options;
  WallFilter filter(options, Pose2{});
  const Eigen::Vector2d m2(options.start_sigma_m * options.start_sigma_m,
                           options.start_sigma_rad * options.start_sigma_rad);
  const Eigen::Matrix3d start = Eigen::Vector3d(m2(0), m2(0), m2(1)).asDiagonal();
  testing::LinesInformationState slow(Eigen::Vector3d::Zero(), start);
  const auto add = [&](const ObservedWall& wall) {
    const std::size_t index = filter.add(wall);
    const Eigen::Vector4d mean = filter.wall_mean(index);
    Eigen::Matrix<double, 4, 3> by_robot;  // the robot stands at the origin
    by_robot << 1, 0, -mean(1), 0, 1, mean(0), 1, 0, -mean(3), 0, 1, mean(2);
    ObservedWall rough = wall;
    rough.across_sigma_m = std::hypot(wall.across_sigma_m, options.across_floor_m);
    rough.direction_sigma_rad = std::hypot(wall.direction_sigma_rad, options.direction_floor_rad);
    slow.append(filter.wall(index).block, mean, by_robot, rough.covariance());
    return filter.wall(index).block;
  };
  const int long_one = add(observed({13.0, -3.0}, {13.0, 0.0}, 26));
  const int short_one = add(observed({13.02, 0.5}, {13.03, 2.0}, 15));
  const int beside = add(observed({2.0, -3.0}, {9.0, -3.0}, 40));

  Eigen::VectorXd both(8);
  both << filter.wall_mean(0), filter.wall_mean(1);
  const auto offsets = [](const Eigen::VectorXd& ends) {  // of b's ends from a's line
    const Eigen::Vector2d way = (ends.segment<2>(2) - ends.head<2>()).normalized();
    const Eigen::Vector2d across(-way.y(), way.x());
    return Eigen::Vector2d(across.dot(ends.segment<2>(4) - ends.head<2>()),
                           across.dot(ends.segment<2>(6) - ends.head<2>()));
  };
  SparseRows rows;
  rows.resize(2);
  rows.num_blocks = 2;
  rows.blocks = {long_one, short_one, 0};
  for (Eigen::Index i = 0; i < 8; ++i) {
    const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(8, i);
    rows.jacobian.col(i) = (offsets(both + step) - offsets(both - step)) / 2e-6;
  }
  rows.innovation = -offsets(both);
  rows.noise.diagonal().setConstant(options.join_sigma_m * options.join_sigma_m);
  slow.correct(rows);
  SparseRows choice;  // the first's start, the second's end
  choice.resize(4);
  choice.num_blocks = 2;
  choice.blocks = {long_one, short_one, 0};
  choice.jacobian.block<2, 2>(0, 0).setIdentity();
  choice.jacobian.block<2, 2>(2, 6).setIdentity();
  Eigen::Vector4d mean;
  mean << slow.mean(long_one).head<2>(), slow.mean(short_one).tail<2>();
  slow.replace(long_one, choice, mean);
  slow.remove(short_one);

  filter.join(0, 1);
  ASSERT_EQ(filter.num_walls(), 2U);
  // Differences of second order: 1e-6 of the Jacobian, of covariances up to 1e-2.
  EXPECT_LE((filter.wall_mean(0) - Eigen::Vector4d(slow.mean(long_one))).cwiseAbs().maxCoeff(),
            1e-8);
  EXPECT_LE(
      (filter.state().dense_covariance(filter.blocks()) - slow.covariance({0, long_one, beside}))
          .cwiseAbs()
          .maxCoeff(),
      1e-8);
}

}  // namespace
}  // namespace marco::slam
