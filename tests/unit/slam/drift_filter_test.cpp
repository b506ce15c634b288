#include "slam/front_end/drift_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/covariance.hpp"
#include "slam/front_end/unknown_scale.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

MotionGuess by_odometry(const Pose2& step, const OdometryNoise& noise) {
  return {step, noise.drift(step), noise.jitter(), MotionGuess::Source::odometry};
}

// The pose that a match of this covariance and the prediction make together.
Pose2 fused(const CarriedPose& carried, const Pose2& match, const Eigen::Matrix3d& information) {
  const Eigen::Matrix3d prior = (carried.drifted.covariance + carried.jitter).inverse();
  const Pose2& predicted = carried.drifted.world_from_robot;
  const Eigen::Vector3d step =
      (prior + information).inverse() * information * difference(match, predicted);
  return {predicted.x_m + step.x(), predicted.y_m + step.y(), predicted.theta_rad + step.z()};
}

// A robot that drives straight on by 5 cm a scan, a keyframe each half metre, and whose odometry
// and matches err.
struct Drive {
  DriftFilter filter;
  OdometryNoise noise;
  Pose2 truth;
  int scans = 0;

  void step(const Pose2& counted, const Pose2& match, const Eigen::Matrix3d& information) {
    const CarriedPose carried = filter.carried(by_odometry(counted, noise));
    filter.correct(carried, {fused(carried, match, information), information}, noise);
    if (++scans % 10 == 0) filter.begin_at_keyframe(0.0, noise);
  }
  double off_m() const {
    return (filter.state().drifted.world_from_robot.translation_m() - truth.translation_m()).norm();
  }
};

// A few returns know a scan's place to 2 cm and its heading to 2 degrees. Wheels that are right
// carry the robot; the errors of its matches must not add up on the way.
TEST(DriftFilter, ManyScansThatKnowLittleDoNotLeadExactWheelsAstray) {
  std::mt19937 random(5);
  std::normal_distribution<double> place(0.0, 0.02), turn(0.0, deg_to_rad(2.0));
  const Eigen::Matrix3d information = diagonal_covariance(0.02, deg_to_rad(2.0)).inverse();
  Drive drive;
  double worst_m = 0.0;
  for (int i = 0; i < 600; ++i) {
    const Pose2 step{0.05, 0, 0};
    drive.truth = drive.truth * step;
    // Matches err against the map, which is where the filter drew it.
    const Pose2 seen =
        drive.filter.carried(by_odometry(step, drive.noise)).drifted.world_from_robot;
    drive.step(step,
               {seen.x_m + place(random), seen.y_m + place(random), seen.theta_rad + turn(random)},
               information);
    worst_m = std::max(worst_m, drive.off_m());
  }
  EXPECT_LT(worst_m, 0.5) << "of 30 m";
  EXPECT_LT(std::abs(rad_to_deg(drive.filter.state().drifted.world_from_robot.theta_rad)), 1.5);
}

TEST(DriftFilter, ScansThatKnowTheirPlaceCorrectWheelsThatAreOff) {
  const Eigen::Matrix3d information = diagonal_covariance(0.002, deg_to_rad(0.1)).inverse();
  Drive drive;
  for (int i = 0; i < 100; ++i) {
    drive.truth = drive.truth * Pose2{0.05, 0, 0};
    drive.step({0.055, 0, deg_to_rad(0.1)}, drive.truth, information);
  }
  EXPECT_LT(drive.off_m(), 0.02) << "wheels alone: half a metre";
}

TEST(DriftFilter, AReadingThatIsOffOnceMovesNothingForGood) {
  const Eigen::Matrix3d information = diagonal_covariance(0.002, deg_to_rad(0.1)).inverse();
  Drive drive;
  for (int i = 0; i < 55; ++i) {
    drive.truth = drive.truth * Pose2{0.05, 0, 0};
    drive.step({0.05, 0, 0}, drive.truth, information);
  }
  // A stamp that is late by 20 ms: the match is 1 cm ahead of where it says.
  drive.truth = drive.truth * Pose2{0.05, 0, 0};
  drive.step({0.05, 0, 0}, drive.truth * Pose2{0.01, 0, 0}, information);
  EXPECT_LT(drive.off_m(), 0.004);
}

TEST(DriftFilter, AfterASlipItIsWhereTheScanSays) {
  const Eigen::Matrix3d information = diagonal_covariance(0.002, deg_to_rad(0.1)).inverse();
  Drive drive;
  const CarriedPose carried = drive.filter.carried(by_odometry({1.0, 0, 0}, drive.noise));
  drive.filter.correct(carried, {Pose2{}, information, 1e-3}, drive.noise);
  EXPECT_THAT(drive.filter.state().drifted.world_from_robot, IsNear(Pose2{}, 0.03, 0.01));
}

TEST(DriftFilter, WhatNothingMeasuresStaysPredicted) {
  DriftFilter filter;
  OdometryNoise noise;
  const Eigen::Matrix3d across = Eigen::Vector3d(0.0, 1e6, 1e6).asDiagonal();
  const CarriedPose carried = filter.carried(by_odometry({1.0, 0, 0}, noise));
  filter.correct(carried, {fused(carried, {5.0, 0.01, 0}, across), across}, noise);
  EXPECT_NEAR(filter.state().drifted.world_from_robot.x_m, 1.0, 1e-9);
  EXPECT_NEAR(filter.state().drifted.covariance(0, 0), carried.drifted.covariance(0, 0), 1e-12);
  EXPECT_LT(filter.state().drifted.covariance(1, 1), carried.drifted.covariance(1, 1));
}

TEST(DriftFilter, FollowsEachMatchWhereThereIsNoOdometry) {
  DriftFilter filter;
  OdometryNoise noise;
  MotionGuess guess;
  guess.before_from_now = {0.1, 0, 0};
  guess.drift = diagonal_covariance(0.03, 0.05);
  guess.source = MotionGuess::Source::velocity;
  const CarriedPose carried = filter.carried(guess);
  const Pose2 found{0.12, 0.02, 0.01};
  filter.correct(carried, {found, diagonal_covariance(0.01, 0.01).inverse()}, noise);
  EXPECT_THAT(filter.state().drifted.world_from_robot, IsNear(found, 1e-9, 1e-9));
  EXPECT_EQ(noise.jitter_m2, OdometryNoise().jitter_m2) << "and learns nothing of wheels";
  filter.begin_at_keyframe(0.0, noise);
  EXPECT_GT(filter.state().since_keyframe(0, 0), 0.0) << "a carried velocity's errors add up";
}

// A keyframe that draws nothing new leaves the robot as far off the map as it was.
TEST(DriftFilter, AKeyframeTakesAsMuchOfTheErrorAsItDrawsOfTheMap) {
  OdometryNoise noise;
  DriftFilter filter;
  filter.follow(filter.carried(by_odometry({1.0, 0, 0}, noise)));
  const Eigen::Matrix3d before = filter.state().drifted.covariance;
  filter.begin_at_keyframe(1.0, noise);
  EXPECT_TRUE(filter.state().drifted.covariance.isApprox(before));
  filter.begin_at_keyframe(0.25, noise);
  EXPECT_TRUE(filter.state().drifted.covariance.isApprox(0.25 * before));
  EXPECT_TRUE(filter.state().since_keyframe.isZero());
}

TEST(DriftFilter, WheelsOfAnotherSizeAreLearnedAndServeWhereScansAreMissing) {
  const Eigen::Matrix3d information = diagonal_covariance(0.003, deg_to_rad(0.1)).inverse();
  const Pose2 step{0.05, 0, deg_to_rad(1.0)};
  const Pose2 counted{1.08 * 0.05, 0, deg_to_rad(0.9)};
  Drive drive;
  for (int i = 0; i < 600; ++i) {
    drive.truth = drive.truth * step;
    drive.step(counted, drive.truth, information);
  }
  EXPECT_NEAR(drive.filter.state().bias.mean.x(), 1.0 / 1.08 - 1.0, 0.02);
  const Pose2 last_seen = drive.filter.state().drifted.world_from_robot;
  Pose2 truth = last_seen, blind = last_seen;
  for (int i = 0; i < 60; ++i) {
    truth = truth * step;
    blind = blind * counted;
    drive.filter.follow(drive.filter.carried(by_odometry(counted, drive.noise)));
  }
  const Pose2& carried = drive.filter.state().drifted.world_from_robot;
  EXPECT_LT(between(truth, carried).translation_m().norm(),
            0.25 * between(truth, blind).translation_m().norm());
}

TEST(UnknownScale, GrowsWithTheWayUntilAScanSeesItAndTurnsWithTheMap) {
  UnknownScale scale;
  for (int i = 0; i < 100; ++i) scale.carry({0.1 * i, 0, 0}, {0.1 * (i + 1), 0, 0});
  EXPECT_NEAR(std::sqrt(scale.covariance()(0, 0)), 0.02 * 10.0, 1e-9);
  EXPECT_NEAR(scale.covariance()(1, 1), 0.0, 1e-12);
  scale.turn(deg_to_rad(90));
  EXPECT_NEAR(std::sqrt(scale.covariance()(1, 1)), 0.02 * 10.0, 1e-9);
  EXPECT_NEAR(scale.covariance()(0, 0), 0.0, 1e-12);
  scale.correct(0.25 * Eigen::Matrix3d::Identity());
  EXPECT_NEAR(std::sqrt(scale.covariance()(1, 1)), 0.25 * 0.02 * 10.0, 1e-9);
}

// A turn that odometry has missed carries the way after it aside.
TEST(UnknownScale, OfATurnMovesTheWayAfterIt) {
  UnknownScale scale;
  scale.carry({0, 0, 0}, {0, 0, 1.0});
  const Pose2 turned{0, 0, 1.0};
  scale.carry(turned, turned * Pose2{5, 0, 0});
  EXPECT_NEAR(std::sqrt(scale.covariance()(2, 2)), 0.02, 1e-9);
  EXPECT_NEAR(std::hypot(scale.error(0, 1), scale.error(1, 1)), 0.02 * 5.0, 1e-9);
}

TEST(DriftFilter, MovesWithTheMap) {
  DriftFilter filter;
  OdometryNoise noise;
  const Pose2 robot{1.0, 2.0, 0.3}, moved{-3.0, 1.0, 1.8};
  filter.follow(filter.carried(by_odometry(robot, noise)));
  filter.move_with_map(robot, moved);
  EXPECT_THAT(filter.state().drifted.world_from_robot, IsNear(moved, 1e-9, 1e-9));
}

}  // namespace
}  // namespace marco::slam
