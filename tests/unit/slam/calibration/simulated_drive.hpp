#pragma once

#include <functional>
#include <numbers>
#include <random>

#include "slam/calibration/self_calibration.hpp"

namespace marco::testing {

/// Velocities of a drive at a moment.
struct DriveSpeed {
  double ahead_m_per_s = 0.0;
  double yaw_rad_per_s = 0.0;
};
using DrivePlan = std::function<DriveSpeed(double seconds)>;

/// Ways and turns of all kinds; speeds change smoothly.
inline DriveSpeed varied_drive(double seconds) {
  return {0.35 + 0.3 * std::sin(0.7 * seconds) + 0.15 * std::sin(2.3 * seconds),
          0.8 * std::sin(0.9 * seconds + 1.0) + 0.4 * std::sin(0.31 * seconds)};
}

/// How robot and sensors really are, and how noisy.
struct SimulatedRobot {
  Pose2 robot_from_laser;
  OdometryCalibration odometry;
  GyroCalibration gyro;
  bool laser_upside_down = false;
  double laser_sigma_m = 0.0;  ///< of the step from scan to scan
  double laser_sigma_rad = 0.0;
};

/// The noisy record of a drive: scans at 10 Hz, odometry at 50 Hz, gyroscope at 50 Hz. Every
/// reading is made from the true motion by the definitions of SensorCalibration turned round, none
/// by the code under test.
inline slam::CalibrationInput simulate(const SimulatedRobot& robot,
                                       const DrivePlan& plan,
                                       double seconds,
                                       unsigned seed = 1) {
  constexpr int kFineSteps = 1000, kOdometryEvery = 20, kScanEvery = 100;  // a second's, each of
  constexpr double kFineS = 1.0 / kFineSteps, kStart = 1000.0;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  slam::CalibrationInput input;
  const OdometryCalibration& wheels = robot.odometry;
  Pose2 world_from_robot, last_laser = robot.robot_from_laser, odom_from_robot;
  Pose2 seen_from_laser;
  double gyro_rad = 0.0;
  const int count = static_cast<int>(seconds * kFineSteps);
  for (int i = 0; i <= count; ++i) {
    const double time_s = i * kFineS;
    if (i % kScanEvery == 0) {
      const Pose2 laser = world_from_robot * robot.robot_from_laser;
      Pose2 step = between(last_laser, laser);
      step =
          step * Pose2{robot.laser_sigma_m * normal(random), robot.laser_sigma_m * normal(random),
                       robot.laser_sigma_rad * normal(random)};
      if (robot.laser_upside_down) step = {step.x_m, -step.y_m, -step.theta_rad};
      seen_from_laser = seen_from_laser * step;
      last_laser = laser;
      input.world_from_laser.push_back({Utime::from_seconds(kStart + time_s), seen_from_laser});
    }
    if (i % kOdometryEvery == 0) {
      input.odometry.push_back(
          {Utime::from_seconds(kStart + time_s + wheels.late_s), odom_from_robot});
      input.gyro_heading.push_back({Utime::from_seconds(kStart + time_s + robot.gyro.late_s),
                                    {0.0, 0.0, normalize_angle(gyro_rad)}});
    }
    const DriveSpeed speed = plan(time_s + 0.5 * kFineS);
    const double ahead_m = kFineS * speed.ahead_m_per_s, turn_rad = kFineS * speed.yaw_rad_per_s;
    world_from_robot = world_from_robot * Pose2{ahead_m * std::cos(0.5 * turn_rad),
                                                ahead_m * std::sin(0.5 * turn_rad), turn_rad};
    const double half_m = 0.5 * kCountedTrackM * wheels.track_scale;
    const double left_m = (ahead_m - half_m * turn_rad) / wheels.left_scale;
    const double right_m = (ahead_m + half_m * turn_rad) / wheels.right_scale;
    const double counted_m = wheels.forward_sign * 0.5 * (left_m + right_m);
    const double counted_rad = wheels.turn_sign * (right_m - left_m) / kCountedTrackM;
    odom_from_robot = odom_from_robot * Pose2{counted_m * std::cos(0.5 * counted_rad),
                                              counted_m * std::sin(0.5 * counted_rad), counted_rad};
    gyro_rad += turn_rad / robot.gyro.scale + kFineS * robot.gyro.bias_rad_per_s;
  }
  return input;
}

/// A robot that drives straight and turns on the spot at corners, with one reading of its odometry
/// a scan, late by a time.
inline slam::CalibrationInput round_a_ring(unsigned seed, double late_s = 0.0) {
  constexpr double kStepM = 0.26, kStepRad = std::numbers::pi / 16, kSpeed = 0.4, kTurn = 1.05;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  slam::CalibrationInput input;
  Pose2 robot, counted;
  double time_s = 1000.0;
  const auto go = [&](double way_m, double turn_rad) {
    time_s += way_m / kSpeed + turn_rad / kTurn;
    robot = robot * Pose2{way_m, 0.0, turn_rad};
    const double way_sigma_m = 0.02 * way_m + 1e-4;
    const double turn_sigma_rad = 0.0026 * std::sqrt(way_m) + 0.01 * turn_rad + 1e-4;
    counted = counted * Pose2{way_m + way_sigma_m * normal(random), 0.0,
                              turn_rad + turn_sigma_rad * normal(random)};
    const Pose2 match_error{5e-4 * normal(random), 5e-4 * normal(random), 2e-4 * normal(random)};
    input.world_from_laser.push_back({Utime::from_seconds(time_s), robot * match_error});
    input.odometry.push_back({Utime::from_seconds(time_s + late_s), counted});
  };
  for (int corner = 0; corner < 5; ++corner) {
    for (int i = 0; i < 110; ++i) go(kStepM, 0.0);
    for (int i = 0; i < 8; ++i) go(0.0, kStepRad);
  }
  return input;
}

}  // namespace marco::testing
