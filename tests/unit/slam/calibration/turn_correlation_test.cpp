#include "slam/calibration/input_check.hpp"

#include <gtest/gtest.h>

#include "tests/unit/slam/calibration/simulated_drive.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::simulate;
using ::marco::testing::SimulatedRobot;
using ::marco::testing::varied_drive;

TurnCorrelation correlate(const CalibrationInput& input) {
  const OdometryTravel travel(input.odometry);
  return correlate_turns(known_motions(laser_motions(input.world_from_laser), travel), travel);
}

TEST(TurnCorrelation, FindsHowLateOdometryIs) {
  for (const double late_s : {-0.3, 0.0, 0.3, 0.72}) {
    SimulatedRobot robot;
    robot.odometry.late_s = late_s;
    robot.laser_sigma_rad = deg_to_rad(0.5);
    const TurnCorrelation found = correlate(simulate(robot, varied_drive, 150.0));
    ASSERT_TRUE(found.is_late_found);
    EXPECT_NEAR(found.late_s, late_s, 0.02);
    EXPECT_NEAR(found.late_s, late_s, 4.0 * found.sigma_late_s);
    EXPECT_GT(found.correlation, 0.98);
    EXPECT_NEAR(found.slope, 1.0, 0.02);
    EXPECT_GT(found.turns, 50);
  }
}

TEST(TurnCorrelation, FindsTurnsTheWrongWayRound) {
  SimulatedRobot robot;
  robot.odometry.turn_sign = -1.0;
  robot.odometry.track_scale = 1.25;
  const TurnCorrelation found = correlate(simulate(robot, varied_drive, 60.0));
  EXPECT_LT(found.correlation, -0.99);
  EXPECT_NEAR(found.slope, -1.0 / 1.25, 1e-3);
}

TEST(TurnCorrelation, FindsNothingOutsideItsReach) {
  SimulatedRobot robot;
  robot.odometry.late_s = 1.4;
  EXPECT_FALSE(correlate(simulate(robot, varied_drive, 60.0)).is_late_found);
}

TEST(TurnCorrelation, IsNothingWhereNothingTurns) {
  CalibrationInput input = simulate({}, varied_drive, 60.0);
  for (StampedPose2& pose : input.odometry) pose.world_from_robot = {};
  const TurnCorrelation found = correlate(input);
  EXPECT_EQ(found.correlation, 0.0);
  EXPECT_EQ(found.slope, 0.0);
}

}  // namespace
}  // namespace marco::slam
