#include <gtest/gtest.h>

#include "slam/line_slam/ekf/joint_compatibility.hpp"
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

// Cupboards before and beside each other, both along the one wall of the map.
TEST(Association, ParallelWallsOfOneScanAreNotBothTheSameWall) {
  const auto matches = after_a_turn().associate(
      {observed({13.0, -3.0}, {13.0, -1.6}, 25), observed({13.05, -1.4}, {13.05, 0.0}, 24), kSide});
  EXPECT_EQ(matches[0].wall, 0);
  EXPECT_EQ(matches[1].wall, WallMatch::kUnclear);
}

// In line with the wall and within the pose's uncertainty of it; the side wall fixes the heading.
TEST(Association, APairingMustHoldFromThePoseThatAllPairingsImply) {
  const auto matches = after_a_turn().associate({kSide, observed({13.0, 0.3}, {13.0, 0.9}, 6)});
  EXPECT_EQ(matches[0].wall, 1);
  EXPECT_EQ(matches[1].wall, WallMatch::kUnclear);
}

// One pairing says that the robot turned left, the other one that it turned right: each passes its
// own gate, since the heading is known to 0.1 rad, but both errors are one.
TEST(JointCompatibility, CountsTheCorrelationOfTheInnovations) {
  const EkfState state(Eigen::Vector3d::Zero(), Eigen::Vector3d(1e-6, 1e-6, 1e-2).asDiagonal());
  const auto candidate = [](int observation, double turn_rad) {
    Candidate made{observation, observation, {}};
    made.rows.resize(2);
    made.rows.num_blocks = 1;
    made.rows.jacobian(0, 2) = 1.0;
    made.rows.innovation(0) = turn_rad;
    made.rows.noise.diagonal().setConstant(1e-4);
    return made;
  };
  const auto chosen = [&](double first_rad, double second_rad) {
    const auto found =
        joint_compatibility(state, {candidate(0, first_rad), candidate(1, second_rad)}, 2, 0.99);
    return (found[0] >= 0 ? 1 : 0) + (found[1] >= 0 ? 1 : 0);
  };
  EXPECT_NEAR(individual_distance2(state, candidate(0, 0.15)), 0.15 * 0.15 / 0.0101, 1e-9);
  EXPECT_EQ(chosen(0.15, -0.15), 1);
  EXPECT_EQ(chosen(0.15, 0.15), 2);
}

// Quantiles of the chi-square distribution as tables print them.
TEST(JointCompatibility, GatesAreTheTablesOfTheChiSquareDistribution) {
  struct Row {
    int degrees;
    double probability, quantile;
  };
  for (const Row& row : {Row{2, 0.95, 5.991}, Row{2, 0.99, 9.210}, Row{4, 0.99, 13.277},
                         Row{10, 0.95, 18.307}, Row{10, 0.99, 23.209}, Row{30, 0.025, 16.791},
                         Row{40, 0.99, 63.691}, Row{100, 0.95, 124.342}}) {
    EXPECT_NEAR(chi_square_limit(row.degrees, row.probability), row.quantile, 0.01 * row.quantile)
        << row.degrees;
  }
}

TEST(Joining, KeepsTheEvidenceOfBothWalls) {
  WallFilter filter(WallFilterOptions{}, Pose2{});
  filter.add(observed({2.0, -3.0}, {5.0, -3.0}, 40));
  filter.add(observed({5.5, -3.0}, {7.0, -3.0}, 20));
  filter.join(0, 1);
  const Walls plan = filter.plan(1, 0.1);
  ASSERT_EQ(plan.size(), 2U) << "nobody has seen what lies between them";
  EXPECT_NEAR(plan[0].end_m.x(), 5.0, 0.11) << "a bin";
  EXPECT_NEAR(plan[1].end_m.x(), 7.0, 0.01);
}

TEST(Joining, SimilarWallsMustPassTheGateToo) {
  const auto joined = [](double apart_m) {
    WallFilter filter(WallFilterOptions{}, Pose2{});
    filter.add(observed({2.0, -3.0}, {6.0, -3.0}, 40));
    filter.add(observed({3.0, -3.0 - apart_m}, {7.0, -3.0 - apart_m}, 40));
    return filter.join_similar({WallMatch{0, 0.0}});
  };
  EXPECT_EQ(joined(0.01), 1);
  EXPECT_EQ(joined(0.15), 0) << "similar, but ten sigma apart";
}

// The part that was seen, of a wall made longer afterwards, has the errors of its own ends.
TEST(Plan, APieceHasTheCovarianceOfThePiece) {
  WallFilter filter(WallFilterOptions{}, Pose2{});
  filter.add(observed({2.0, -3.0}, {6.0, -3.0}, 40));
  ObservedWall farther = observed({2.0, -3.0}, {10.0, -3.0}, 80);
  farther.end_sigma_m = 0.5;
  filter.extend({farther}, {WallMatch{0, 0.0}});
  const Walls plan = filter.plan(1, 0.1);
  ASSERT_EQ(plan.size(), 1U);
  ASSERT_NEAR(plan[0].end_m.x(), 6.0, 0.11);
  const double part = (plan[0].end_m.x() - 2.0) / 8.0;
  const Eigen::Matrix4d whole =
      filter.state().covariance(filter.wall(0).block, filter.wall(0).block);
  ASSERT_GT(whole(2, 2), 0.25) << "the far end along the wall";
  const double expected = (1.0 - part) * (1.0 - part) * whole(0, 0) + part * part * whole(2, 2) +
                          2.0 * part * (1.0 - part) * whole(0, 2);
  EXPECT_NEAR(plan[0].covariance(2, 2), expected, 1e-12);
  EXPECT_LT(plan[0].covariance(2, 2), 0.5 * whole(2, 2));
}

}  // namespace
}  // namespace marco::slam
