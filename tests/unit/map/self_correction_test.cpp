#include "tools/map/self_correction.hpp"

#include <gtest/gtest.h>

#include "common/covariance.hpp"

namespace marco {
namespace {

slam::PoseGraphEdge step(double length_m, double along_sigma_m, bool is_loop = false) {
  const Eigen::Vector3d variance(along_sigma_m * along_sigma_m, 1e-4, 1e-6);
  return {0, 1, Pose2{length_m, 0, 0}, information_of(variance.asDiagonal()), is_loop};
}

TEST(SelfCorrection, OdometryToldTheWayWhereScansLeftItOpen) {
  EXPECT_EQ(distance_by_odometry_m({}), 0.0);
  EXPECT_NEAR(distance_by_odometry_m(
                  {step(0.4, 0.009), step(0.5, 0.03), step(9.0, 0.5, true), step(0.5, 0.02)}),
              1.0, 1e-9);
}

// A scale that is off by 1.5 % is nothing in rooms, and 1.5 m along 100 m of bare corridor.
TEST(SelfCorrection, ASmallErrorOfScaleIsCorrectedAlongBareCorridors) {
  slam::SelfCalibration found;
  found.calibration.odometry.left_scale = found.calibration.odometry.right_scale = 0.985;
  EXPECT_EQ(needed_correction(found, 0.0), SensorCalibration{});
  EXPECT_EQ(needed_correction(found, 15.0), SensorCalibration{});
  EXPECT_EQ(needed_correction(found, 100.0).odometry, found.calibration.odometry);
  found.calibration.odometry.left_scale = found.calibration.odometry.right_scale = 0.9;
  EXPECT_EQ(needed_correction(found, 0.0).odometry, found.calibration.odometry);
}

// What is late by 50 ms costs no more than reading between samples does.
TEST(SelfCorrection, OnlySurelyLateOdometryAndGyroscopesAreReadAtAnotherTime) {
  slam::SelfCalibration found;
  const auto measure = [&](double late_s) {
    const auto state = slam::ParameterVerdict::applied;
    found.parameters = {{"odometry.late_s", 0.0, late_s, 0.011, state, ""},
                        {"gyro.late_s", 0.0, late_s, 0.011, state, ""}};
    found.calibration.odometry.late_s = found.calibration.gyro.late_s = late_s;
  };
  measure(-0.06);
  EXPECT_EQ(needed_correction(found, 0.0), SensorCalibration{});
  found.calibration.odometry.left_scale = found.calibration.gyro.scale = -1.0;
  EXPECT_EQ(needed_correction(found, 0.0).odometry.left_scale, -1.0);
  EXPECT_EQ(needed_correction(found, 0.0).odometry.late_s, 0.0);
  EXPECT_EQ(needed_correction(found, 0.0).gyro.scale, -1.0);
  EXPECT_EQ(needed_correction(found, 0.0).gyro.late_s, 0.0);
  found.calibration.odometry.left_scale = found.calibration.gyro.scale = 1.0;
  measure(-0.08);
  EXPECT_EQ(needed_correction(found, 0.0).odometry.late_s, -0.08);
  EXPECT_EQ(needed_correction(found, 0.0).gyro.late_s, -0.08);
}

// Odometry says "ahead" where the scans move aside.
TEST(SelfCorrection, ALaserThatSurelyLooksElsewhereIsTurnedWhereItIsSaidToSit) {
  slam::SelfCalibration found;
  found.calibration.laser = {"LIDAR", 0.31, -0.02, 0.0, false};
  const auto measure = [&](double yaw_deg, double sigma_deg) {
    const auto state = slam::ParameterVerdict::applied;
    found.parameters = {{"laser.x_m", 0.2, 0.31, 0.01, state, ""},
                        {"laser.y_m", 0.0, -0.02, 0.01, state, ""},
                        {"laser.yaw_deg", 10.0, yaw_deg, sigma_deg, state, ""}};
    found.calibration.laser.yaw_deg = yaw_deg;
    return needed_correction(found, 0.0).laser;
  };
  EXPECT_EQ(measure(14.0, 0.1), LaserCalibration{}) << "as much as the front end allows for";
  EXPECT_EQ(measure(-80.0, 45.0), LaserCalibration{}) << "not sure";
  EXPECT_EQ(measure(-80.0, 0.1), (LaserCalibration{"LIDAR", 0.2, 0.0, -80.0, false}));
  found.parameters.push_back(
      {"laser.upside_down", 0.0, 1.0, 0.0, slam::ParameterVerdict::applied, ""});
  found.calibration.laser.upside_down = true;
  EXPECT_EQ(needed_correction(found, 0.0).laser,
            (LaserCalibration{"LIDAR", 0.2, 0.0, -80.0, true}));
}

}  // namespace
}  // namespace marco
