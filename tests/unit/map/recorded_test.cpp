#include "tools/map/map_job.hpp"

#include <gmock/gmock.h>

#include "tools/map/beam_search.hpp"

namespace marco {
namespace {

using slam::ParameterVerdict;

Utime at_ms(int64_t ms) { return Utime::from_us(1000 * ms); }

ImuSample turning(int64_t ms, double rate_rad_per_s) {
  ImuSample sample;
  sample.utime = at_ms(ms);
  sample.angular_velocity_rad_per_s.z() = rate_rad_per_s;
  return sample;
}

TEST(Recorded, TheGyroscopesHeadingIsItsRateSummedUp) {
  Recorded recorded;
  for (int i = 0; i <= 100; ++i) recorded.add(turning(10 * i, 0.5));
  ASSERT_EQ(recorded.gyro_heading.size(), 101U);
  EXPECT_EQ(recorded.gyro_heading.front().world_from_robot.theta_rad, 0.0);
  EXPECT_NEAR(recorded.gyro_heading.back().world_from_robot.theta_rad, 0.5, 1e-9);
  EXPECT_EQ(recorded.gyro_heading.back().utime, at_ms(1000));
  // Neither a sample that comes twice or late, nor a gap of minutes, turns it.
  recorded.add(turning(1000, 9.0));
  recorded.add(turning(900, 9.0));
  EXPECT_EQ(recorded.gyro_heading.size(), 101U);
  recorded.add(turning(300'000, 0.5));
  ASSERT_EQ(recorded.gyro_heading.size(), 102U);
  EXPECT_NEAR(recorded.gyro_heading.back().world_from_robot.theta_rad, 0.5, 1e-9);
}

TEST(Recorded, BearingsAreCountedFromTheLeastOfEachLasersFirstScan) {
  Recorded recorded;
  LaserScan scan;
  scan.channel = "LIDAR_BACK";
  recorded.add(scan);  // without a beam
  EXPECT_EQ(recorded.least_bearing_rad("LIDAR_BACK"), 0.0);
  scan.ranges_m.resize(4);
  scan.first_bearing_rad = 1.5;
  scan.bearing_step_rad = -1.0;  // clockwise
  recorded.add(scan);
  EXPECT_EQ(recorded.least_bearing_rad("LIDAR_BACK"), -1.5);
  scan.bearing_step_rad = -1.2;
  recorded.add(scan);
  EXPECT_EQ(recorded.least_bearing_rad("LIDAR_BACK"), -1.5);
  EXPECT_EQ(recorded.least_bearing_rad("LIDAR"), 0.0);
}

TEST(Recorded, OdometryTruthAndTheNewestMountsAreKept) {
  Recorded recorded;
  OdometrySample odometry;
  odometry.utime = at_ms(3);
  odometry.odom_from_robot = {1, 2, 0.5};
  recorded.add(odometry);
  recorded.add(TruePose{at_ms(4), {3, 4, 0}});
  SensorInfo info;
  recorded.add(info);
  info.range_max_m = 30.0;
  recorded.add(info);
  ASSERT_EQ(recorded.odometry.size(), 1U);
  EXPECT_EQ(recorded.odometry[0].utime, at_ms(3));
  EXPECT_EQ(recorded.odometry[0].world_from_robot, odometry.odom_from_robot);
  ASSERT_EQ(recorded.truth.poses.size(), 1U);
  EXPECT_EQ(recorded.sensors.at("LIDAR").range_max_m, 30.0);
}

BeamSearch search(slam::Estimate bearing_scale, slam::Estimate range_offset_m) {
  return {{"LIDAR", 0.9, 0.02}, {bearing_scale, range_offset_m}};
}

TEST(BeamSearch, WhatIsOffIsCorrectedOverWhatIsInUse) {
  const BeamSearch right = search({1.001, 0.001}, {0.002, 0.001});
  EXPECT_FALSE(right.is_off());
  EXPECT_EQ(right.corrected().bearing_scale, 0.9);
  EXPECT_EQ(right.corrected().range_offset_m, 0.02);
  const BeamSearch wide = search({1.1, 0.001}, {0.002, 0.001});
  EXPECT_TRUE(wide.is_off());
  EXPECT_NEAR(wide.corrected().bearing_scale, 0.99, 1e-12);
  EXPECT_EQ(wide.corrected().range_offset_m, 0.02);
  EXPECT_EQ(wide.corrected().channel, "LIDAR");
  const BeamSearch shorter = search({1.001, 0.001}, {-0.05, 0.001});
  EXPECT_TRUE(shorter.is_off());
  EXPECT_EQ(shorter.corrected().bearing_scale, 0.9);
  EXPECT_NEAR(shorter.corrected().range_offset_m, -0.03, 1e-12);
}

TEST(BeamSearch, IsTabledWithWhatCameOfIt) {
  for (const bool better : {true, false}) {
    slam::SelfCalibration table;
    search({1.1, 0.001}, {0.002, 0.001}).add_to(table, better);
    ASSERT_EQ(table.parameters.size(), 2U);
    const auto& [scale, offset] = std::tie(table.parameters[0], table.parameters[1]);
    EXPECT_EQ(scale.name, "beams.bearing_scale");
    EXPECT_EQ(scale.before, 0.9);
    EXPECT_NEAR(scale.found, 0.99, 1e-12);
    EXPECT_NEAR(scale.sigma, 0.0009, 1e-12) << "of the corrected one";
    EXPECT_EQ(scale.verdict, better ? ParameterVerdict::applied : ParameterVerdict::no_better);
    EXPECT_EQ(offset.name, "beams.range_offset_m");
    EXPECT_EQ(offset.before, 0.02);
    EXPECT_NEAR(offset.found, 0.022, 1e-12);
    EXPECT_EQ(offset.sigma, 0.001);
    EXPECT_EQ(offset.verdict, ParameterVerdict::as_assumed);
  }
}

}  // namespace
}  // namespace marco
