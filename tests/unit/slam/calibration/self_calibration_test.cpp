#include "slam/calibration/self_calibration.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/matchers.hpp"
#include "tests/unit/slam/calibration/simulated_drive.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::DrivePlan;
using ::marco::testing::DriveSpeed;
using ::marco::testing::round_a_ring;
using ::marco::testing::simulate;
using ::marco::testing::SimulatedRobot;
using ::marco::testing::varied_drive;

SimulatedRobot noisy_robot() {
  SimulatedRobot robot;
  robot.laser_sigma_m = 0.002;
  robot.laser_sigma_rad = deg_to_rad(0.1);
  return robot;
}

SelfCalibration calibrate(const SimulatedRobot& robot, double seconds = 200.0) {
  CalibrationInput input = simulate(robot, varied_drive, seconds);
  input.gyro_heading.clear();
  return self_calibrate(input);
}

const CalibratedParameter& parameter(const SelfCalibration& result, const std::string& name) {
  static const CalibratedParameter kNone;
  const CalibratedParameter* found = result.find(name);
  EXPECT_NE(found, nullptr) << name;
  return found == nullptr ? kNone : *found;
}

void expect_applied(const SelfCalibration& result, const std::string& name, double value) {
  const CalibratedParameter& found = parameter(result, name);
  EXPECT_EQ(found.verdict, ParameterVerdict::applied) << name << ' ' << found.found;
  EXPECT_NEAR(found.found, value, std::max(3.0 * found.sigma, 1e-12)) << name;
}

bool says(const SelfCalibration& result, const std::string& words) {
  for (const std::string& remark : result.remarks) {
    if (remark.find(words) != std::string::npos) return true;
  }
  return false;
}

TEST(SelfCalibration, LeavesAGoodRobotAlone) {
  const SelfCalibration result = calibrate(noisy_robot());
  EXPECT_EQ(result.odometry.state, InputState::good);
  ASSERT_EQ(result.parameters.size(), 10U);
  for (const CalibratedParameter& found : result.parameters) {
    EXPECT_EQ(found.verdict, ParameterVerdict::as_assumed) << found.name << ' ' << found.found;
  }
  EXPECT_EQ(result.calibration.odometry, OdometryCalibration{});
  EXPECT_EQ(result.calibration.laser.channel, "");
  EXPECT_TRUE(result.remarks.empty());
}

TEST(SelfCalibration, FindsWheelsLaserAndTimeTogether) {
  SimulatedRobot robot = noisy_robot();
  robot.robot_from_laser = {0.3, -0.1, deg_to_rad(30)};
  robot.odometry.left_scale = 0.9;
  robot.odometry.right_scale = 1.05;
  robot.odometry.track_scale = 1.2;
  robot.odometry.late_s = 0.3;
  const SelfCalibration result = calibrate(robot);
  expect_applied(result, "laser.x_m", 0.3);
  expect_applied(result, "laser.y_m", -0.1);
  expect_applied(result, "laser.yaw_deg", 30.0);
  expect_applied(result, "odometry.left_scale", 0.9);
  expect_applied(result, "odometry.right_scale", 1.05);
  expect_applied(result, "odometry.track_scale", 1.2);
  expect_applied(result, "odometry.late_s", 0.3);
  EXPECT_EQ(result.calibration.laser.channel, "LIDAR");
  EXPECT_NEAR(result.calibration.laser.yaw_deg, 30.0, 0.1);
  EXPECT_NEAR(result.calibration.odometry.left_scale, 0.9, 0.01);
}

// calibration.toml holds no more than a full turn.
TEST(SelfCalibration, AHeadingThatIsFoundStaysWithinHalfATurn) {
  SimulatedRobot robot = noisy_robot();
  robot.robot_from_laser = {0.0, 0.0, deg_to_rad(170)};
  CalibrationInput input = simulate(robot, varied_drive, 200.0);
  input.gyro_heading.clear();
  input.robot_from_laser.theta_rad = deg_to_rad(-100);
  EXPECT_NEAR(self_calibrate(input).calibration.laser.yaw_deg, 170.0, 0.2);
}

// Odometry of a point that is not the axle's middle, and of a front that is another, by uneven
// wheels.
TEST(SelfCalibration, FindsTheAxleByItsOdometry) {
  SimulatedRobot robot = noisy_robot();
  robot.odometry.left_scale = 0.8;
  const Pose2 robot_from_axle{-0.25, 0.0, deg_to_rad(-20)};
  CalibrationInput input = simulate(robot, varied_drive, 200.0);
  input.gyro_heading.clear();
  for (StampedPose2& pose : input.odometry) {
    pose.world_from_robot = pose.world_from_robot * robot_from_axle.inverse();
  }
  const SelfCalibration result = self_calibrate(input);
  expect_applied(result, "odometry.left_scale", 0.8);
  EXPECT_EQ(parameter(result, "odometry.right_scale").verdict, ParameterVerdict::as_assumed);
  expect_applied(result, "laser.x_m", -0.25);
  expect_applied(result, "laser.yaw_deg", -20.0);
  EXPECT_NEAR(result.calibration.odometry.axle_x_m, -0.25, 0.005);
  EXPECT_NEAR(result.calibration.odometry.axle_yaw_deg, -20.0, 0.5);
}

TEST(SelfCalibration, FindsHalfAndThreeHalvesOfTheWay) {
  for (const double scale : {0.5, 1.5}) {
    SimulatedRobot robot = noisy_robot();
    robot.odometry.left_scale = robot.odometry.right_scale = scale;
    const SelfCalibration result = calibrate(robot);
    expect_applied(result, "odometry.left_scale", scale);
    expect_applied(result, "odometry.right_scale", scale);
    EXPECT_EQ(parameter(result, "odometry.track_scale").verdict, ParameterVerdict::as_assumed);
  }
}

TEST(SelfCalibration, AShortDriveIsEnough) {
  SimulatedRobot robot = noisy_robot();
  robot.odometry.left_scale = robot.odometry.right_scale = 1.3;
  expect_applied(calibrate(robot, 30.0), "odometry.left_scale", 1.3);
}

TEST(SelfCalibration, FindsTimeWithinFiveMilliseconds) {
  for (const double late_s : {-0.3, 0.3}) {
    SimulatedRobot robot = noisy_robot();
    robot.odometry.late_s = late_s;
    const SelfCalibration result = calibrate(robot);
    EXPECT_NEAR(parameter(result, "odometry.late_s").found, late_s, 0.005);
    expect_applied(result, "odometry.late_s", late_s);
  }
}

// The noise is least midway between two readings: the time must not go there.
TEST(SelfCalibration, TurnsTellTheTimeOfSparseOdometry) {
  for (const double late_s : {0.0, 0.3, -0.2}) {
    const SelfCalibration result = self_calibrate(round_a_ring(1, late_s));
    const CalibratedParameter& late = parameter(result, "odometry.late_s");
    EXPECT_NEAR(late.found, late_s, 0.03);
    EXPECT_NEAR(late.found, late_s, 4.0 * late.sigma);
  }
}

// Between its readings odometry goes at their mean speed, which the robot does not: what is read
// for a short motion is off either way, and a fit to it would make the wheels too small.
TEST(SelfCalibration, SparseOdometryTellsTheWheelsScales) {
  constexpr std::size_t kEvery = 31;  // 50 Hz -> 1.6 Hz
  const DrivePlan stop_and_go = [](double seconds) {
    const DriveSpeed speed = varied_drive(seconds);
    return std::fmod(seconds, 1.4) < 0.7 ? DriveSpeed{} : speed;
  };
  for (const double late_s : {0.0, 0.3}) {
    SimulatedRobot robot = noisy_robot();
    robot.odometry.left_scale = robot.odometry.right_scale = 0.95;
    robot.odometry.late_s = late_s;
    CalibrationInput input = simulate(robot, stop_and_go, 600.0, 3);
    Trajectory sparse;
    for (std::size_t i = 0; i < input.odometry.size(); i += kEvery) {
      sparse.push_back(input.odometry[i]);
    }
    input.odometry = sparse;
    const SelfCalibration result = self_calibrate(input);
    for (const char* name : {"odometry.left_scale", "odometry.right_scale"}) {
      const CalibratedParameter& scale = parameter(result, name);
      EXPECT_NEAR(scale.found, 0.95, 0.02);
      EXPECT_NEAR(scale.found, 0.95, 3.0 * scale.sigma);
    }
  }
}

TEST(SelfCalibration, BelievesThatRobotsDriveAhead) {
  SimulatedRobot backwards = noisy_robot(), turned = noisy_robot();
  backwards.odometry.forward_sign = -1.0;
  turned.robot_from_laser = {0.1, 0.05, -std::numbers::pi};
  const SelfCalibration one = calibrate(backwards), other = calibrate(turned);
  expect_applied(one, "odometry.forward_sign", -1.0);
  EXPECT_EQ(parameter(one, "laser.yaw_deg").verdict, ParameterVerdict::undecidable);
  EXPECT_NEAR(one.calibration.laser.yaw_deg, 0.0, 1e-12);
  EXPECT_EQ(one.calibration.odometry.forward_sign, -1.0);
  EXPECT_EQ(parameter(other, "laser.yaw_deg").verdict, ParameterVerdict::applied);
  EXPECT_NEAR(std::abs(other.calibration.laser.yaw_deg), 180.0, 0.5);
  expect_applied(other, "laser.x_m", 0.1);
  expect_applied(other, "laser.y_m", 0.05);
  EXPECT_EQ(other.calibration.odometry.forward_sign, 1.0);
  EXPECT_TRUE(says(one, "looks back"));
  EXPECT_TRUE(says(other, "looks back"));
}

TEST(SelfCalibration, SaysThatMirrorAndTurnSignAreTheSame) {
  for (const bool mirrored : {false, true}) {
    SimulatedRobot robot = noisy_robot();
    robot.robot_from_laser = {0.2, 0.1, 0.0};
    robot.laser_upside_down = mirrored;
    if (!mirrored) robot.odometry.turn_sign = -1.0;
    const SelfCalibration result = calibrate(robot);
    EXPECT_TRUE(result.calibration.laser.upside_down);
    EXPECT_NE(result.open_question.find("mirror image"), std::string::npos);
    // Of a mirrored world the laser's place is the other side's.
    expect_applied(result, "laser.y_m", mirrored ? 0.1 : -0.1);
  }
}

TEST(SelfCalibration, GyroTellsMirrorFromTurnSign) {
  SimulatedRobot robot = noisy_robot();
  robot.laser_upside_down = true;
  robot.gyro = {0.95, 0.01, 0.1};
  const SelfCalibration mirrored = self_calibrate(simulate(robot, varied_drive, 200.0));
  EXPECT_TRUE(mirrored.calibration.laser.upside_down);
  EXPECT_EQ(mirrored.calibration.odometry.turn_sign, 1.0);
  EXPECT_EQ(mirrored.open_question, "");  // two against one
  expect_applied(mirrored, "gyro.scale", 0.95);
  expect_applied(mirrored, "gyro.bias_rad_per_s", 0.01);
  expect_applied(mirrored, "gyro.late_s", 0.1);
  robot.laser_upside_down = false;
  robot.odometry.turn_sign = -1.0;
  const SelfCalibration wrong = self_calibrate(simulate(robot, varied_drive, 200.0));
  EXPECT_FALSE(wrong.calibration.laser.upside_down);
  EXPECT_EQ(wrong.calibration.odometry.turn_sign, -1.0);
  robot.odometry.turn_sign = 1.0;
  robot.gyro.scale = -0.95;
  const SelfCalibration upside_down = self_calibrate(simulate(robot, varied_drive, 200.0));
  EXPECT_FALSE(upside_down.calibration.laser.upside_down);
  EXPECT_EQ(upside_down.calibration.odometry.turn_sign, 1.0);
  expect_applied(upside_down, "gyro.scale", -0.95);
}

TEST(SelfCalibration, GyroAloneIsCalibratedToo) {
  SimulatedRobot robot = noisy_robot();
  robot.gyro = {deg_to_rad(1.0), 0.5, 0.0};
  CalibrationInput input = simulate(robot, varied_drive, 200.0);
  input.odometry.clear();
  const SelfCalibration result = self_calibrate(input);
  EXPECT_EQ(result.odometry.state, InputState::none);
  expect_applied(result, "gyro.scale", deg_to_rad(1.0));
  EXPECT_EQ(result.find("laser.x_m"), nullptr);
}

TEST(SelfCalibration, NamesOdometryThatNeverMoves) {
  CalibrationInput input = simulate(noisy_robot(), varied_drive, 100.0);
  input.gyro_heading.clear();
  for (StampedPose2& pose : input.odometry) pose.world_from_robot = {3, 4, 1};
  const SelfCalibration result = self_calibrate(input);
  EXPECT_EQ(result.odometry.state, InputState::constant);
  EXPECT_TRUE(says(result, "never moves"));
  EXPECT_EQ(result.calibration.odometry, OdometryCalibration{});
}

TEST(SelfCalibration, NamesOdometryThatStandsStillAtTimes) {
  SimulatedRobot robot = noisy_robot();
  robot.odometry.left_scale = 0.9;
  CalibrationInput input = simulate(robot, varied_drive, 200.0);
  input.gyro_heading.clear();
  // Between 50 and 90 s nothing is counted.
  const Pose2 before = input.odometry[2500].world_from_robot;
  const Pose2 after_from_before = before * input.odometry[4500].world_from_robot.inverse();
  for (std::size_t i = 2500; i < input.odometry.size(); ++i) {
    Pose2& pose = input.odometry[i].world_from_robot;
    pose = i < 4500 ? before : after_from_before * pose;
  }
  const SelfCalibration result = self_calibrate(input);
  EXPECT_EQ(result.odometry.state, InputState::stalled);
  EXPECT_NEAR(result.odometry.stalled_share, 0.2, 0.03);
  expect_applied(result, "odometry.left_scale", 0.9);
}

TEST(SelfCalibration, NamesOdometryOfAnotherRobot) {
  CalibrationInput input = simulate(noisy_robot(), varied_drive, 200.0);
  const auto other = [](double seconds) {
    return DriveSpeed{0.4, 0.7 * std::sin(1.7 * seconds) + 0.5 * std::cos(0.53 * seconds)};
  };
  input.odometry = simulate(noisy_robot(), other, 200.0).odometry;
  input.gyro_heading.clear();
  const SelfCalibration result = self_calibrate(input);
  EXPECT_EQ(result.odometry.state, InputState::foreign);
  EXPECT_TRUE(says(result, "another robot's"));
  EXPECT_EQ(result.calibration.odometry, OdometryCalibration{});
}

// @param missing  what is to be named for each of these parameters
void expect_missing(const testing::DrivePlan& plan,
                    const std::map<std::string, std::string>& missing) {
  CalibrationInput input = simulate(noisy_robot(), plan, 80.0);
  input.gyro_heading.clear();
  const SelfCalibration result = self_calibrate(input);
  for (const auto& [name, what] : missing) {
    const CalibratedParameter& found = parameter(result, name);
    EXPECT_EQ(found.verdict, ParameterVerdict::not_observed) << name;
    EXPECT_EQ(found.found, found.before) << name;
    EXPECT_EQ(found.missing, what) << name;
  }
}

TEST(SelfCalibration, EachKindOfMotionNamesWhatItLacks) {
  const auto straight = [](double seconds) { return DriveSpeed{0.5 * std::sin(0.5 * seconds), 0}; };
  const auto spin = [](double seconds) { return DriveSpeed{0, 0.8 * std::sin(0.5 * seconds)}; };
  const auto arc = [](double seconds) {
    return DriveSpeed{0.5 * std::sin(0.5 * seconds), 0.4 * std::sin(0.5 * seconds)};
  };
  const auto steady = [](double) { return DriveSpeed{0.4, 0.3}; };
  const std::string ways = "driving besides turns on the spot";
  expect_missing(straight, {{"laser.x_m", "turns"}, {"odometry.track_scale", "turns"}});
  expect_missing(spin, {{"laser.yaw_deg", ways}, {"odometry.left_scale", ways}});
  expect_missing(arc, {{"laser.y_m", "arcs with another radius"}});
  expect_missing(steady, {{"odometry.late_s", "changes of speed"}});
}

TEST(SelfCalibration, NeedsADrive) {
  EXPECT_EQ(self_calibrate({}).odometry.state, InputState::none);
  const auto standing = [](double) { return DriveSpeed{}; };
  const SelfCalibration result = self_calibrate(simulate(noisy_robot(), standing, 60.0));
  EXPECT_EQ(result.odometry.state, InputState::none);
  EXPECT_TRUE(result.parameters.empty());
}

}  // namespace
}  // namespace marco::slam
