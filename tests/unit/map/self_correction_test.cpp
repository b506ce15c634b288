#include "tools/map/self_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

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

// Odometry says "ahead" where the scans move aside: the path is that of the point and the heading
// that odometry means.
TEST(SelfCorrection, TheLaserIsPutWhereItSurelySits) {
  slam::SelfCalibration found;
  const auto measure = [&](const Pose2& laser, double sigma_m, double sigma_deg) {
    const auto state = slam::ParameterVerdict::applied;
    const double yaw_deg = std::round(rad_to_deg(laser.theta_rad));
    found.parameters = {{"laser.x_m", 0.2, laser.x_m, sigma_m, state, ""},
                        {"laser.y_m", 0.0, laser.y_m, sigma_m, state, ""},
                        {"laser.yaw_deg", 10.0, yaw_deg, sigma_deg, state, ""}};
    found.calibration.laser = {"LIDAR", laser.x_m, laser.y_m, yaw_deg, false};
    return needed_correction(found, 0.0);
  };
  EXPECT_EQ(measure({0.3, 0, deg_to_rad(14.0)}, 0.01, 0.1), SensorCalibration{});
  EXPECT_EQ(measure({0.5, 0.4, deg_to_rad(-80.0)}, 0.2, 45.0), SensorCalibration{}) << "not sure";
  EXPECT_FALSE(assumed_from_found_robot(found));
  for (const Pose2& laser : {Pose2{0.2, 0, deg_to_rad(-80.0)}, Pose2{-0.1, 0.0, deg_to_rad(10.0)},
                             Pose2{0.2, 0.3, deg_to_rad(10.0)}}) {
    SensorCalibration only_the_laser;
    EXPECT_EQ(measure(laser, 0.01, 0.1).laser, found.calibration.laser);
    only_the_laser.laser = found.calibration.laser;
    EXPECT_EQ(measure(laser, 0.01, 0.1), only_the_laser);
  }
  // Turned, and a hand's breadth ahead: the place stays the one that the recording names.
  EXPECT_EQ(measure({0.3, 0.05, deg_to_rad(-80.0)}, 0.01, 0.1).laser,
            (LaserCalibration{"LIDAR", 0.2, 0.0, -80.0, false}));
}

// Off by 90 degrees, give or take 3: both paths are given, and nothing is corrected.
TEST(SelfCorrection, ATurnInDoubtIsNotCorrected) {
  slam::SelfCalibration found;
  const auto state = slam::ParameterVerdict::applied;
  found.parameters = {{"laser.x_m", 0.2, 0.2, 0.01, slam::ParameterVerdict::as_assumed, ""},
                      {"laser.y_m", 0.0, 0.0, 0.01, slam::ParameterVerdict::as_assumed, ""},
                      {"laser.yaw_deg", 10.0, 100.0, 3.0, state, ""}};
  found.calibration.laser = {"LIDAR", 0.2, 0.0, 100.0, false};
  EXPECT_EQ(needed_correction(found, 0.0), SensorCalibration{});
  const auto robot = assumed_from_found_robot(found);
  ASSERT_TRUE(robot);
  // Both see the laser at one place.
  const Pose2 by_said{0.2, 0.0, deg_to_rad(10.0)}, by_found{0.2, 0.0, deg_to_rad(100.0)};
  EXPECT_LT(between(*robot * by_found, by_said).vector().norm(), 1e-9);
  EXPECT_NE(doubt_of_laser(found).find("turned by 100 deg (sd 3.0)"), std::string::npos);
}

TEST(SelfCorrection, WheelsThatCountBackwardsVeerOrTurnTooFarAreCorrected) {
  const auto needed = [](const auto& spoil) {
    slam::SelfCalibration found;
    spoil(found.calibration.odometry);
    return needed_correction(found, 0.0).odometry == found.calibration.odometry;
  };
  EXPECT_TRUE(needed([](OdometryCalibration& wheels) { wheels.forward_sign = -1.0; }));
  EXPECT_TRUE(needed([](OdometryCalibration& wheels) { wheels.turn_sign = -1.0; }));
  EXPECT_TRUE(needed([](OdometryCalibration& wheels) { wheels.track_scale = 1.2; }));
  EXPECT_FALSE(needed([](OdometryCalibration& wheels) { wheels.track_scale = 1.03; }));
  // 2.9 and 8.6 degrees a metre, to either side.
  for (const double side : {-1.0, 1.0}) {
    EXPECT_FALSE(needed([=](OdometryCalibration& wheels) { wheels.left_scale -= 0.02 * side; }));
    EXPECT_TRUE(needed([=](OdometryCalibration& wheels) {
      wheels.left_scale -= 0.03 * side;
      wheels.right_scale += 0.03 * side;
    }));
  }
}

TEST(SelfCorrection, AGyroscopeIsCorrectedForAWrongScaleOrALargeBias) {
  slam::SelfCalibration found;
  found.calibration.gyro = {1.05, 0.005, 0.0};
  EXPECT_EQ(needed_correction(found, 0.0).gyro, GyroCalibration{});
  for (const GyroCalibration& gyro :
       {GyroCalibration{1.1, 0.0, 0.0}, GyroCalibration{0.9, 0.0, 0.0},
        GyroCalibration{1.0, 0.02, 0.0}, GyroCalibration{1.0, -0.02, 0.0}}) {
    found.calibration.gyro = gyro;
    EXPECT_EQ(needed_correction(found, 0.0).gyro, gyro);
  }
}

TEST(SelfCorrection, ALaserUpsideDownIsTurnedOverWhereItIsSaidToSit) {
  slam::SelfCalibration found;
  const auto as_assumed = slam::ParameterVerdict::as_assumed;
  found.parameters = {{"laser.x_m", 0.2, 0.25, 0.01, as_assumed, ""},
                      {"laser.y_m", 0.1, 0.1, 0.01, as_assumed, ""},
                      {"laser.yaw_deg", 10.0, 11.0, 0.1, as_assumed, ""},
                      {"laser.upside_down", 0.0, 1.0, 0.0, as_assumed, ""}};
  found.calibration.laser = {"LIDAR", 0.25, 0.1, 11.0, true};
  EXPECT_EQ(needed_correction(found, 0.0), SensorCalibration{});
  found.parameters.back().verdict = slam::ParameterVerdict::applied;
  EXPECT_EQ(needed_correction(found, 0.0).laser, (LaserCalibration{"LIDAR", 0.2, 0.1, 10.0, true}));
}

TEST(SelfCorrection, WhatIsOffIsSaidAndTheReportHoldsWhatBecameOfAll) {
  using slam::ParameterVerdict;
  SelfCorrection correction;
  correction.found.parameters = {
      {"odometry.left_scale", 1.0, 1.9, 0.003, ParameterVerdict::applied, ""},
      {"odometry.turn_sign", 1.0, -1.0, 0.0, ParameterVerdict::applied, ""},
      {"gyro.scale", 1.0, 1.01, 0.02, ParameterVerdict::as_assumed, ""},
      {"laser.x_m", 0.2, 0.0, 0.0, ParameterVerdict::not_observed, "turns"},
      {"laser.y_m", 0.0, 0.4, 0.01, ParameterVerdict::no_better, ""},
      {"laser.yaw_deg", 0.0, 4.0, 1.0, ParameterVerdict::undecidable, ""}};
  correction.found.remarks = {"turn more"};
  correction.use = SelfCorrection::Use::in_force;
  EXPECT_EQ(describe_errors(correction.found),
            "odometry.left_scale 1 -> 1.9 (sd 0.003), odometry.turn_sign 1 -> -1");
  EXPECT_EQ(describe_errors({}), "");
  nlohmann::json report;
  add_calibration(report, correction);
  const auto& reported = report.at("calibration");
  EXPECT_EQ(reported.at("use"), "in_force");
  EXPECT_EQ(reported.at("remarks"), nlohmann::json({"turn more"}));
  EXPECT_FALSE(reported.contains("path_as_found"));
  const char* const states[] = {"off",          "off",       "as_assumed",
                                "not_observed", "no_better", "undecidable"};
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(reported.at("parameters")[i].at("state"), states[i]);
  EXPECT_EQ(reported.at("parameters")[0].at("sigma"), 0.003);
  EXPECT_FALSE(reported.at("parameters")[1].contains("sigma"));
  EXPECT_FALSE(reported.at("parameters")[1].contains("missing"));
  EXPECT_FALSE(reported.at("parameters")[3].contains("found"));
  EXPECT_EQ(reported.at("parameters")[3].at("missing"), "turns");
  correction.use = SelfCorrection::Use::rejected;
  correction.assumed_from_found_robot = Pose2{};
  add_calibration(report, correction);
  EXPECT_EQ(report["calibration"]["use"], "rejected");
  EXPECT_EQ(report["calibration"]["path_as_found"], kPathAsFound);
  ::testing::internal::CaptureStdout();
  print_correction(correction);
  std::fflush(stdout);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(),
            "set-up: odometry.left_scale 1 -> 1.9 (sd 0.003), odometry.turn_sign 1 -> -1\n"
            "  note: turn more\n"
            "  a map made with these was no better: they are not used\n"
            "  trajectory_as_found.tum is the path for the mount as found\n");
}

}  // namespace
}  // namespace marco
