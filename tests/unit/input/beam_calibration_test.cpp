#include "common/input/sensor_calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace marco {
namespace {

TEST(BeamCalibration, StretchesBearingsAboutTheSensorsAxis) {
  LaserScan even;
  even.first_bearing_rad = -1.0;
  even.bearing_step_rad = 0.5;
  even.ranges_m = {1.0F, 1.0F, 1.0F, 1.0F, 1.0F};
  LaserScan listed = even;
  listed.bearings_rad = {-1.0F, 0.0F, 0.25F};
  const BeamCalibration wider{"LIDAR", 1.02, 0.0};
  wider.correct(even, 30.0);
  wider.correct(listed, 30.0);
  EXPECT_NEAR(even.bearing_rad(0), -1.02, 1e-12);
  EXPECT_NEAR(even.bearing_rad(2), 0.0, 1e-12);
  EXPECT_NEAR(even.bearing_rad(4), 1.02, 1e-12);
  EXPECT_NEAR(listed.bearing_rad(2), 0.255, 1e-6);
  EXPECT_EQ(even.ranges_m, std::vector<float>(5, 1.0F));
}

TEST(BeamCalibration, WhatIsNoReturnStaysNone) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  LaserScan scan;
  scan.ranges_m = {2.0F, 0.0F, -1.0F, 8.0F, 20.0F, kInfinite, 0.03F};
  BeamCalibration{"LIDAR", 1.0, -0.05}.correct(scan, 8.0);
  EXPECT_FLOAT_EQ(scan.ranges_m[0], 1.95F);
  EXPECT_EQ(scan.ranges_m[1], 0.0F);
  EXPECT_EQ(scan.ranges_m[2], -1.0F);
  EXPECT_EQ(scan.ranges_m[3], 8.0F);
  EXPECT_EQ(scan.ranges_m[4], 20.0F);
  EXPECT_EQ(scan.ranges_m[5], kInfinite);
  EXPECT_EQ(scan.ranges_m[6], 0.0F);
  LaserScan unknown;
  unknown.ranges_m = {std::nanf("")};
  BeamCalibration{"LIDAR", 1.0, 0.05}.correct(unknown, 8.0);
  EXPECT_TRUE(std::isnan(unknown.ranges_m[0]));
}

}  // namespace
}  // namespace marco
