#include "slam/calibration/refinement.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "slam/calibration/motion_samples.hpp"
#include "tests/unit/slam/calibration/simulated_drive.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::DriveSpeed;
using ::marco::testing::round_a_ring;
using ::marco::testing::simulate;
using ::marco::testing::SimulatedRobot;
using ::marco::testing::varied_drive;

const ModelPrior kPrior{to_vector({1.0, 1.0, kCountedTrackM, {}}, 0.0),
                        (ModelVector() << 0.3, 0.3, 0.12, 0.3, 0.3, 0.5, 0.3).finished()};

SimulatedRobot uneven_robot() {
  SimulatedRobot robot;
  robot.robot_from_laser = {0.12, -0.05, 0.2};
  robot.odometry.left_scale = 1.03;
  robot.odometry.right_scale = 0.97;
  robot.odometry.track_scale = 1.08;
  robot.odometry.late_s = 0.15;
  robot.laser_sigma_m = 0.002;
  robot.laser_sigma_rad = deg_to_rad(0.1);
  return robot;
}

ModelVector truth_of(const SimulatedRobot& robot) {
  const OdometryCalibration& wheels = robot.odometry;
  return to_vector({wheels.left_scale, wheels.right_scale, wheels.track_scale * kCountedTrackM,
                    robot.robot_from_laser},
                   wheels.late_s);
}

RefinedModel refined(const CalibrationInput& input) {
  const OdometryTravel travel(input.odometry);
  const auto motions = known_motions(laser_motions(input.world_from_laser), travel);
  return refine(
      [&](double late_s) {
        OdometryCalibration late;
        late.late_s = late_s;
        return motion_samples(motions, travel, late);
      },
      kPrior.mean, kPrior);
}

TEST(Refinement, FindsEverythingWithoutNoise) {
  SimulatedRobot robot = uneven_robot();
  robot.laser_sigma_m = robot.laser_sigma_rad = 0.0;
  const RefinedModel found = refined(simulate(robot, varied_drive, 100.0));
  const ModelVector off = found.parameters - truth_of(robot);
  // Between readings the speed is taken to be steady.
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-3) << off.transpose();
}

TEST(Refinement, ErrorsOfManyRunsAreAsItSays) {
  constexpr int kRuns = 50;
  const SimulatedRobot robot = uneven_robot();
  const ModelVector truth = truth_of(robot);
  double laser = 0.0, wheels = 0.0, time = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const RefinedModel found = refined(simulate(robot, varied_drive, 60.0, seed));
    const ModelVector off = found.parameters - truth;
    const Eigen::Matrix3d laser_part = found.covariance.block<3, 3>(kLaserX, kLaserX);
    const Eigen::Matrix3d wheel_part = found.covariance.block<3, 3>(kLeftScale, kLeftScale);
    laser += off.segment<3>(kLaserX).dot(laser_part.inverse() * off.segment<3>(kLaserX));
    wheels += off.segment<3>(kLeftScale).dot(wheel_part.inverse() * off.segment<3>(kLeftScale));
    time += off[kLate] * off[kLate] / found.covariance(kLate, kLate);
    for (const bool observed : found.observed) EXPECT_TRUE(observed);
  }
  // 95 % of chi-square sums of 50 x 3, and of 50.
  EXPECT_GT(laser / kRuns, 2.36);
  EXPECT_LT(laser / kRuns, 3.72);
  EXPECT_GT(wheels / kRuns, 2.36);
  EXPECT_LT(wheels / kRuns, 3.72);
  EXPECT_GT(time / kRuns, 0.65);
  EXPECT_LT(time / kRuns, 1.43);
}

// Noise of turns is that of turns, not that of the straight ways which are most of the drive.
TEST(Refinement, RareTurnsAreAsNoisyAsTurns) {
  constexpr int kRuns = 8;
  double turns = 0.0, places = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const CalibrationInput input = round_a_ring(seed);
    const OdometryTravel travel(input.odometry);
    const auto motions =
        known_motions(laser_motions(input.world_from_laser, motion_length_s(travel)), travel);
    const SamplesAt samples_at = [&](double) { return motion_samples(motions, travel, {}); };
    const RefinedModel found = refine(samples_at, kPrior.mean, kPrior);
    const ModelVector off = found.parameters - kPrior.mean;
    turns += off[kTrack] * off[kTrack] / found.covariance(kTrack, kTrack);
    places += off.segment<2>(kLaserX)
                  .cwiseAbs2()
                  .cwiseQuotient(found.covariance.diagonal().segment<2>(kLaserX))
                  .sum();
  }
  // Honest were 1, and 2. Motions of one reading: 4.9.
  EXPECT_LT(turns / kRuns, 2.0);
  EXPECT_LT(places / kRuns, 2.0);
}

TEST(Refinement, OutliersDoNotCount) {
  const SimulatedRobot robot = uneven_robot();
  CalibrationInput input = simulate(robot, varied_drive, 100.0);
  // Ten times the laser is lost: all poses from there on are elsewhere.
  for (std::size_t i = 0; i < input.world_from_laser.size(); ++i) {
    Pose2& pose = input.world_from_laser[i].world_from_robot;
    pose = Pose2{0.5 * static_cast<double>(i / 100), 0.0, 0.0} * pose;
  }
  const RefinedModel found = refined(input);
  const ModelVector off = found.parameters - truth_of(robot);
  for (int i = 0; i < kModelParameters; ++i) {
    EXPECT_LT(std::abs(off[i]), 3.0 * std::sqrt(found.covariance(i, i))) << i;
  }
}

void expect_observed(const RefinedModel& found, const std::vector<int>& expected) {
  for (int i = 0; i < kModelParameters; ++i) {
    const bool is_expected = std::find(expected.begin(), expected.end(), i) != expected.end();
    EXPECT_EQ(found.observed[static_cast<std::size_t>(i)], is_expected) << "parameter " << i;
    if (is_expected) continue;
    EXPECT_EQ(found.parameters[i], kPrior.mean[i]) << "parameter " << i;
  }
}

TEST(Refinement, StraightWaysHoldRadiiAndYaw) {
  SimulatedRobot robot = uneven_robot();
  // It goes straight because it is steered so, whatever its wheels are.
  const auto straight = [](double seconds) { return DriveSpeed{0.5 * std::sin(0.5 * seconds), 0}; };
  const RefinedModel found = refined(simulate(robot, straight, 200.0));
  expect_observed(found, {kLeftScale, kRightScale, kLaserYaw, kLate});
  EXPECT_NEAR(found.parameters[kLaserYaw], 0.2, 0.01);
  EXPECT_NEAR(found.parameters[kLeftScale], 1.03, 0.01);
  EXPECT_NEAR(found.parameters[kRightScale], 0.97, 0.01);
}

// Turns of an odometry that only trembles say nothing of the laser's place.
TEST(Refinement, NoiseIsNoTurn) {
  const auto straight = [](double seconds) { return DriveSpeed{0.5 * std::sin(0.5 * seconds), 0}; };
  CalibrationInput input = simulate(uneven_robot(), straight, 200.0);
  std::mt19937 random(7);
  std::normal_distribution<double> trembling_rad(0.0, deg_to_rad(1.0));
  for (StampedPose2& pose : input.odometry) {
    pose.world_from_robot.theta_rad += trembling_rad(random);
  }
  const RefinedModel found = refined(input);
  EXPECT_FALSE(found.observed[kLaserX]);
  EXPECT_FALSE(found.observed[kLaserY]);
  EXPECT_FALSE(found.observed[kTrack]);
}

TEST(Refinement, SteadySpeedHoldsNoTime) {
  const auto steady = [](double) { return DriveSpeed{0.4, 0.3}; };
  const RefinedModel found = refined(simulate(uneven_robot(), steady, 200.0));
  EXPECT_FALSE(found.observed[kLate]);
}

TEST(Refinement, SpinHoldsNoWaysAndNoHeading) {
  const auto spin = [](double seconds) { return DriveSpeed{0.0, 0.8 * std::sin(0.5 * seconds)}; };
  const RefinedModel found = refined(simulate(uneven_robot(), spin, 200.0));
  EXPECT_FALSE(found.observed[kLeftScale]);
  EXPECT_FALSE(found.observed[kRightScale]);
  EXPECT_FALSE(found.observed[kTrack]);
  EXPECT_FALSE(found.observed[kLaserYaw]);
  EXPECT_TRUE(found.observed[kLate]);
}

TEST(Refinement, OneArcToAndFroLacksThreeDirections) {
  const auto arc = [](double seconds) {
    const double speed = 0.5 * std::sin(0.5 * seconds);
    return DriveSpeed{speed, 0.8 * speed};
  };
  SimulatedRobot robot = uneven_robot();
  const RefinedModel found = refined(simulate(robot, arc, 200.0));
  EXPECT_FALSE(found.observed[kTrack]);
  EXPECT_FALSE(found.observed[kLaserY]);
  const auto observed = std::count(found.observed.begin(), found.observed.end(), true);
  EXPECT_LE(observed, 4) << found.covariance.diagonal().cwiseSqrt().transpose();
}

TEST(Refinement, TwoKindsOfMotionHoldAll) {
  const auto straight_and_spin = [](double seconds) {
    const double speed = std::sin(0.5 * seconds);
    return std::fmod(seconds, 25.0) < 12.5 ? DriveSpeed{0.5 * speed, 0.0}
                                           : DriveSpeed{0.0, 0.8 * speed};
  };
  const RefinedModel found = refined(simulate(uneven_robot(), straight_and_spin, 200.0));
  for (const bool observed : found.observed) EXPECT_TRUE(observed);
}

}  // namespace
}  // namespace marco::slam
