// What a guard may believe of its sensors, and what they show.
#include "drivers/base/sensor_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/base/surroundings.hpp"

namespace marco::drivers {
namespace {

using ::testing::HasSubstr;

SensorInfo mounted(const std::string& channel, double height_m = 0.3, double pitch_deg = 0.0) {
  SensorInfo info;
  info.channel = channel;
  info.parent_from_sensor = make_pose3({0.1, 0.0, height_m}, 0.0, deg_to_rad(pitch_deg));
  info.tilt_axis_m = {0.1, 0.0, 0.2};
  info.range_min_m = 0.1;
  info.range_max_m = 8.0;
  return info;
}

class WatchedSensors : public ::testing::Test {
 protected:
  void wait(double seconds) { now_ = now_ + Duration::from_seconds(seconds); }
  void read(const std::string& name, int times, double every_s) {
    for (int i = 0; i < times; ++i) {
      wait(every_s);
      EXPECT_TRUE(watch_.on_reading(name, now_, now_));
    }
  }
  SensorWatch watch_{Heights{0.08, 1.2}};
  Utime now_ = Utime::from_seconds(1000.0);
};

TEST_F(WatchedSensors, TheFirstMountHoldsAndAnotherIsInDisputeForTenSeconds) {
  const SensorInfo first = mounted("LIDAR");
  watch_.on_info(first, now_);
  SensorInfo alike = first;
  alike.parent_from_sensor.translation().x() += 0.0005;
  watch_.on_info(alike, now_);
  EXPECT_EQ(watch_.dispute(now_), "");
  std::vector<SensorInfo> others(7, first);
  others[0].mount = SensorInfo::Mount::pantilt;
  others[1].parent_from_sensor.translation().y() += 0.0015;
  others[2].parent_from_sensor.rotate(
      Eigen::AngleAxisd(deg_to_rad(0.15), Eigen::Vector3d::UnitZ()));
  others[3].tilt_axis_m.x() += 0.0015;
  others[4].range_min_m += 0.0015;
  others[5].range_max_m += 0.0015;
  others[6].range_max_m -= 0.0015;
  for (const SensorInfo& other : others) {
    watch_.on_info(other, now_);
    EXPECT_EQ(watch_.dispute(now_), "another mount for LIDAR is refused");
    wait(9.5);
    EXPECT_NE(watch_.dispute(now_), "");
    wait(1.0);
    EXPECT_EQ(watch_.dispute(now_), "");
  }
  EXPECT_EQ(watch_.info_of("LIDAR")->range_max_m, 8.0);
}

TEST_F(WatchedSensors, OnlyLasersAndThePanTiltAreKept) {
  for (const char* channel : {"CAMERA", "IMU", "LIDAR_FRONT", "PANTILT_STATE"}) {
    watch_.on_info(mounted(channel), now_);
  }
  EXPECT_EQ(watch_.info_of("CAMERA"), nullptr);
  EXPECT_EQ(watch_.forget(), "LIDAR_FRONT, PANTILT_STATE");
  EXPECT_EQ(watch_.info_of("LIDAR_FRONT"), nullptr);
}

TEST_F(WatchedSensors, AReadingCountsOnceAndOfSixteenSensors) {
  EXPECT_TRUE(watch_.on_reading("LIDAR", now_, now_));
  EXPECT_FALSE(watch_.on_reading("LIDAR", now_, now_));
  EXPECT_EQ(watch_.info_of("LIDAR"), nullptr);
  for (int i = 1; i < 16; ++i) EXPECT_TRUE(watch_.on_reading(std::to_string(i), now_, now_));
  EXPECT_FALSE(watch_.on_reading("17", now_, now_));
  wait(0.1);
  EXPECT_TRUE(watch_.on_reading("LIDAR", now_, now_));
}

TEST_F(WatchedSensors, AreSilentAfterThreeIntervalsHalfASecondAtLeast) {
  struct Case {
    double interval_s, patience_s;
  };
  for (const auto& [interval_s, patience_s] : {Case{0.1, 0.5}, Case{0.3, 0.9}, Case{0.8, 1.5}}) {
    watch_.forget();
    watch_.on_info(mounted("LIDAR"), now_);
    wait(5.0);
    EXPECT_EQ(watch_.silent(now_), "") << "it never came";
    read("LIDAR", 1, 0.1);
    wait(5.0);
    EXPECT_EQ(watch_.silent(now_), "") << "it came once";
    read("LIDAR", 20, interval_s);
    wait(patience_s - 0.05);
    EXPECT_EQ(watch_.silent(now_), "") << interval_s;
    wait(0.15);
    EXPECT_THAT(watch_.silent(now_), HasSubstr("LIDAR is silent for ")) << interval_s;
    wait(1.8 - patience_s - 0.1);
    EXPECT_EQ(watch_.silent(now_), "LIDAR is silent for 1.8 s");
    wait(0.7);  // away
    read("LIDAR", 2, interval_s);
    wait(patience_s + 0.1);
    EXPECT_THAT(watch_.silent(now_), HasSubstr("LIDAR")) << "that it was away makes it no slower";
  }
}

TEST_F(WatchedSensors, SonarsFallSilentAndALaserWithoutAMountDoesNot) {
  read("LIDAR", 5, 0.1);
  wait(2.0);
  EXPECT_EQ(watch_.silent(now_), "");
  read(SensorWatch::kSonars, 5, 0.1);
  wait(0.7);
  EXPECT_EQ(watch_.silent(now_), "SONAR is silent for 0.7 s");
}

TEST_F(WatchedSensors, WhatALevelLaserSeesIsAsHighAsTheRobot) {
  EXPECT_TRUE(watch_.counted(mounted("LIDAR", 0.02).parent_from_sensor).contain(5.0));
  EXPECT_TRUE(watch_.counted(mounted("LIDAR", 0.3, 2.0).parent_from_sensor).contain(0.0));
  const Heights tilted = watch_.counted(mounted("LIDAR", 0.3, 5.0).parent_from_sensor);
  EXPECT_FALSE(tilted.contain(0.05));
  EXPECT_TRUE(tilted.contain(0.5));
}

TEST_F(WatchedSensors, ALaserOnAPanTiltIsWhereTheHeadLooks) {
  SensorInfo laser = mounted("LIDAR", 0.1), base = mounted("PANTILT_STATE", 0.6);
  laser.mount = SensorInfo::Mount::pantilt;
  watch_.on_info(laser, now_);
  watch_.on_info(base, now_);
  EXPECT_FALSE(watch_.robot_from(laser, now_));
  PanTiltState state;
  state.pan_rad = 1.0;
  watch_.on_pantilt(state, now_);
  ASSERT_TRUE(watch_.robot_from(laser, now_));
  EXPECT_NEAR(watch_.robot_from(laser, now_)->linear()(1, 0), std::sin(1.0), 1e-9);
  wait(2.0);
  EXPECT_FALSE(watch_.robot_from(laser, now_)) << "the head may be elsewhere by now";
  watch_.on_pantilt(state, now_);
  watch_.forget();
  watch_.on_info(base, now_);
  EXPECT_FALSE(watch_.robot_from(laser, now_));
}

TEST_F(WatchedSensors, WhyNoneIsOfUseIsSaidOfEach) {
  EXPECT_EQ(watch_.why_blind(now_), "no laser or sonar data");
  watch_.on_info(mounted("PANTILT_STATE", 0.6), now_);
  EXPECT_EQ(watch_.why_blind(now_), "no laser or sonar data");
  read("LIDAR", 1, 0.1);
  EXPECT_EQ(watch_.why_blind(now_), "LIDAR has no SENSOR_INFO");
  read("LIDAR_REAR", 1, 0.1);
  SensorInfo rear = mounted("LIDAR_REAR");
  rear.mount = SensorInfo::Mount::pantilt;
  watch_.on_info(rear, now_);
  EXPECT_EQ(watch_.why_blind(now_), "LIDAR has no SENSOR_INFO, LIDAR_REAR has no PANTILT_STATE");
  watch_.on_info(mounted("LIDAR"), now_);
  EXPECT_THAT(watch_.why_blind(now_), HasSubstr("LIDAR sees nothing at the body's height, "));
  watch_.on_useful("LIDAR", now_);
  EXPECT_EQ(watch_.why_blind(now_), "");
  wait(2.0);
  EXPECT_EQ(watch_.why_blind(now_), "LIDAR is silent, LIDAR_REAR is silent");
  read("LIDAR", 1, 0.1);
  EXPECT_EQ(watch_.why_blind(now_),
            "LIDAR sees nothing at the body's height, LIDAR_REAR is silent");
  read(SensorWatch::kSonars, 1, 0.1);
  EXPECT_EQ(watch_.why_blind(now_), "");
}

TEST_F(WatchedSensors, ALaserIsOfNoUseInDisputeWithoutHeightOrAboveTheBody) {
  const auto why = [&](const SensorInfo& info, const SensorInfo& then) {
    watch_.forget();
    watch_.on_info(info, now_);
    watch_.on_info(then, now_);
    watch_.on_info(mounted("PANTILT_STATE", 0.0), now_);
    watch_.on_pantilt({}, now_);
    read("LIDAR", 1, 0.1);
    watch_.on_useful("LIDAR", now_);
    return watch_.why_blind(now_);
  };
  const SensorInfo right = mounted("LIDAR"), none = mounted("LIDAR", 0.0);
  SensorInfo on_head = right;
  on_head.mount = SensorInfo::Mount::pantilt;
  EXPECT_EQ(why(right, right), "");
  EXPECT_EQ(why(right, none), "LIDAR is in dispute");
  EXPECT_EQ(why(none, none), "LIDAR has no height (position_m)");
  EXPECT_EQ(why(on_head, on_head), "LIDAR has no height (position_m)") << "the pan-tilt's";
  EXPECT_EQ(why(mounted("LIDAR", 1.3), mounted("LIDAR", 1.3)),
            "LIDAR is above the body (max_height_m)");
  EXPECT_EQ(why(mounted("LIDAR", 1.3, 20.0), mounted("LIDAR", 1.3, 20.0)), "") << "it looks down";
}

class ShownAround : public ::testing::Test {
 protected:
  ShownAround() { around_.note_time(now_); }
  void wait(double seconds) {
    now_ = now_ + Duration::from_seconds(seconds);
    around_.note_time(now_);
  }
  void stand_at(const Pose2& pose) {
    around_.on_odometry({now_, pose});
    pose_ = pose;
  }
  void sound(double range_m, Surroundings::Sonars read = Surroundings::Sonars::always) {
    around_.on_sonar({now_, {{range_m, {0.25, 0.0, 0.5}}}, 0.4}, pose_, now_, read);
  }
  /// Nine beams from -0.4 rad on, a tenth apart.
  void scan(const std::vector<float>& ranges_m) {
    LaserScan scan;
    scan.utime = now_;
    scan.ranges_m = ranges_m;
    scan.first_bearing_rad = -0.4;
    scan.bearing_step_rad = 0.1;
    around_.on_scan(scan, pose_, now_);
  }
  std::size_t points() const { return around_.points_within(3.0).size(); }

  Surroundings around_{Footprint(Footprint::box(0.30, 0.30, 0.27)), {0.08, 1.2}};
  Utime now_ = Utime::from_seconds(1000.0);
  Pose2 pose_;
};

TEST_F(ShownAround, AnEchoLiesOnTheMiddleOfItsConeAndHalfWayToItsRims) {
  stand_at({5.0, 3.0, 1.0});
  sound(1.0);
  stand_at({5.2, 3.1, 0.7});
  const Pose2 robot_then{5.0, 3.0, 1.0};
  const auto found = around_.points_within(3.0);
  ASSERT_EQ(found.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const double bearing_rad = 0.5 + 0.1 * (static_cast<double>(i) - 1.0);
    const Eigen::Vector2d then(0.25 + std::cos(bearing_rad), std::sin(bearing_rad));
    EXPECT_LT((found[i] - pose_.inverse() * (robot_then * then)).norm(), 1e-9) << i;
  }
}

TEST_F(ShownAround, ASonarSeesTheGroundBeforeItsEchoAndTwoMetresWithoutOne) {
  stand_at({5.0, 3.0, 1.0});
  const auto ground_at = [&](double way_m) {
    return around_.ground_at(Pose2{0.25, 0.0, 0.5} * Eigen::Vector2d(way_m, 0.0));
  };
  sound(1.0);
  EXPECT_EQ(ground_at(0.8), LocalMap::Ground::seen);
  EXPECT_EQ(ground_at(1.4), LocalMap::Ground::unknown);
  sound(0.0);
  EXPECT_EQ(points(), 0U);
  EXPECT_EQ(ground_at(1.8), LocalMap::Ground::seen);
  EXPECT_EQ(ground_at(2.35), LocalMap::Ground::unknown);
}

TEST_F(ShownAround, SonarsOfTheRobotItselfOldOnesAndForgottenOnesCountNot) {
  stand_at({});
  sound(0.04);
  EXPECT_EQ(points(), 0U) << "within the body";
  sound(1.0);
  wait(29.0);
  EXPECT_EQ(points(), 3U);
  wait(2.0);
  EXPECT_EQ(points(), 0U);
  sound(1.0);
  EXPECT_EQ(around_.forget(), "SONAR");
  EXPECT_EQ(points(), 0U);
}

TEST_F(ShownAround, SonarsThatAreReadAtRestAloneAreNeitherMissedNorEnough) {
  stand_at({});
  for (int i = 0; i < 5; ++i) {
    sound(1.0, Surroundings::Sonars::at_rest);
    wait(0.1);
  }
  EXPECT_EQ(points(), 3U);
  EXPECT_EQ(around_.why_blind(), "no laser or sonar data");
  wait(3.0);
  EXPECT_EQ(around_.silent(), "");
}

TEST_F(ShownAround, OdometryThatJumpsForgetsWhatWasSeen) {
  around_.on_sensor_info(mounted("LIDAR"));
  for (const double jump_m : {0.8, 1.2}) {
    stand_at({});
    scan({2, 2, 2, 2, 2, 2, 2, 2, 2});
    ASSERT_GT(points(), 0U);
    stand_at({jump_m, 0.0, 0.0});
    EXPECT_EQ(points() > 0U, jump_m < 1.0);
  }
}

TEST_F(ShownAround, ReturnsOfTheRobotTooNearOnesAndNoReturnsAreNoPoints) {
  const float none = std::nanf("");
  stand_at({});
  scan({2, 2, 2, 2, 2, 2, 2, 2, 2});
  EXPECT_EQ(points(), 0U) << "without its mount";
  around_.on_sensor_info(mounted("LIDAR"));
  wait(0.1);
  scan({0.15F, 0.15F, 0.05F, 2.0F, none, 0.0F, 8.0F, 9.0F, -1.0F});
  EXPECT_EQ(points(), 1U);
  EXPECT_EQ(around_.why_blind(), "");
  wait(0.1);
  // Ground under beams that saw nothing as far as they see, or had no answer, is seen.
  EXPECT_EQ(around_.ground_at({0.1 + 2.0 * std::cos(0.2), 2.0 * std::sin(0.2)}),
            LocalMap::Ground::seen);
  EXPECT_EQ(around_.ground_at({0.1 + 1.5 * std::cos(-0.4), 1.5 * std::sin(-0.4)}),
            LocalMap::Ground::unknown)
      << "behind the robot's own part";
}

// Somebody's coat over it: it sees nothing.
TEST_F(ShownAround, AScanWithoutAnyHitIsOfNoUse) {
  stand_at({});
  around_.on_sensor_info(mounted("LIDAR"));
  scan({9, 9, 9, 9, 9, 9, 9, 9, 9});
  EXPECT_EQ(around_.why_blind(), "LIDAR sees nothing at the body's height");
  EXPECT_EQ(around_.ground_at({1.0, 0.0}), LocalMap::Ground::unknown);
}

// Of a laser whose beams follow each other through 0.2 s, on a robot that turns by 1 rad/s.
TEST_F(ShownAround, BeamTimesDeskewAScan) {
  around_.on_sensor_info(mounted("LIDAR"));
  LaserScan scan;
  scan.utime = now_;
  scan.first_bearing_rad = -0.4;
  scan.bearing_step_rad = 0.1;
  scan.ranges_m.assign(9, 9.0F);
  scan.ranges_m[4] = 2.0F;
  for (int i = 0; i < 9; ++i) scan.time_offsets_s.push_back(0.025F * static_cast<float>(i));
  for (int i = 0; i <= 20; ++i) {
    stand_at({0.0, 0.0, 0.01 * i});
    wait(0.01);
  }
  around_.on_scan(scan, pose_, now_);
  const auto found = around_.points_within(3.0);
  ASSERT_EQ(found.size(), 1U);
  // The middle beam was measured when 4/9 of the turn were done.
  const Eigen::Vector2d wanted = Pose2{0.0, 0.0, 4.0 / 9.0 * 0.2 - 0.2} * Eigen::Vector2d(2.1, 0.0);
  EXPECT_LT((found[0] - wanted).norm(), 0.01);
}

}  // namespace
}  // namespace marco::drivers
