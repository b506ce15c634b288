#include "slam/calibration/gyro_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

#include "tests/unit/slam/calibration/simulated_drive.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::simulate;
using ::marco::testing::SimulatedRobot;
using ::marco::testing::varied_drive;

GyroFit fit(const CalibrationInput& input) {
  const OdometryTravel travel(input.gyro_heading);
  return fit_gyro(known_motions(laser_motions(input.world_from_laser), travel), travel);
}

TEST(GyroFit, FindsScaleBiasAndTime) {
  SimulatedRobot robot;
  robot.gyro = {0.9, 0.02, -0.3};
  robot.laser_sigma_rad = deg_to_rad(0.05);
  const GyroFit found = fit(simulate(robot, varied_drive, 200.0));
  EXPECT_NEAR(found.found.scale, 0.9, 2.0 * found.sigma.scale);
  EXPECT_NEAR(found.found.bias_rad_per_s, 0.02, 2.0 * found.sigma.bias_rad_per_s);
  EXPECT_NEAR(found.found.late_s, -0.3, 2.0 * found.sigma.late_s);
  EXPECT_LT(found.sigma.scale, 0.002);
  EXPECT_LT(found.sigma.bias_rad_per_s, 0.001);
  EXPECT_LT(found.sigma.late_s, 0.005);
}

TEST(GyroFit, FindsDegreesUpsideDown) {
  SimulatedRobot robot;
  robot.gyro.scale = -deg_to_rad(1.0);
  const GyroFit found = fit(simulate(robot, varied_drive, 60.0));
  EXPECT_LT(found.turns.correlation, -0.99);
  EXPECT_NEAR(found.found.scale, -deg_to_rad(1.0), 1e-5);
}

TEST(GyroFit, MeanSquaredErrorOfManyRunsIsAsItSays) {
  constexpr int kRuns = 50;
  SimulatedRobot robot;
  robot.gyro = {1.05, -0.01, 0.1};
  robot.laser_sigma_rad = deg_to_rad(0.1);
  double sum = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const GyroFit found = fit(simulate(robot, varied_drive, 60.0, seed));
    sum += std::pow((found.found.scale - 1.05) / found.sigma.scale, 2) +
           std::pow((found.found.bias_rad_per_s + 0.01) / found.sigma.bias_rad_per_s, 2) +
           std::pow((found.found.late_s - 0.1) / found.sigma.late_s, 2);
  }
  // 95 % of chi-square sums of 50 x 3.
  EXPECT_GT(sum / kRuns, 2.36);
  EXPECT_LT(sum / kRuns, 3.72);
}

// A fifth of the drive tells of another time: the other four are more.
TEST(GyroFit, IsJudgedByAllPartsOfTheDrive) {
  SimulatedRobot robot;
  robot.laser_sigma_rad = deg_to_rad(0.05);
  const Trajectory in_time = simulate(robot, varied_drive, 200.0).gyro_heading;
  robot.gyro.late_s = -0.1;
  CalibrationInput input = simulate(robot, varied_drive, 200.0);
  const std::vector<LaserMotion> fifth = split(laser_motions(input.world_from_laser)).held_out;
  const auto is_of_fifth = [&](const StampedPose2& heading) {
    return std::any_of(fifth.begin(), fifth.end(), [&](const LaserMotion& motion) {
      return heading.utime.seconds() >= motion.begin_s && heading.utime.seconds() <= motion.end_s;
    });
  };
  std::erase_if(input.gyro_heading, is_of_fifth);
  std::copy_if(in_time.begin(), in_time.end(), std::back_inserter(input.gyro_heading), is_of_fifth);
  std::sort(input.gyro_heading.begin(), input.gyro_heading.end(),
            [](const auto& a, const auto& b) { return a.utime < b.utime; });
  const GyroFit found = fit(input);
  EXPECT_NEAR(found.found.late_s, -0.1, 0.01);
  EXPECT_TRUE(found.better[2]);
}

}  // namespace
}  // namespace marco::slam
