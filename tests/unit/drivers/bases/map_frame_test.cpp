#include "teleop/map_frame.hpp"

#include <gmock/gmock.h>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/matchers.hpp"

namespace marco::teleop {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::testing::HasSubstr;

Utime second(double s) { return Utime::from_seconds(s); }

// A robot that drives 0.5 m/s along the odometry's x, on a map that lies turned by a quarter.
class MapFrameTest : public ::testing::Test {
 protected:
  void add_odometry(double from_s, double to_s) {
    for (double s = from_s; s <= to_s; s += 0.1) {
      frame_.on_odometry({second(s), {0.5 * (s - 100.0), 0.0, 0.0}});
    }
  }
  const Pose2 odom_from_map_{1.0, -2.0, 1.5707963};
  MapFrame frame_;
};

TEST_F(MapFrameTest, AGoalOnTheMapIsAPointOfTheOdometry) {
  add_odometry(100.0, 102.0);
  // The pose of a scan of half a second ago: odometry went on since.
  const Pose2 odom_from_robot{0.75, 0.0, 0.0};
  frame_.on_slam_pose(second(101.5), odom_from_map_.inverse() * odom_from_robot, second(102.0));
  EXPECT_THAT(frame_.odom_from_map(second(102.0)), IsNear(odom_from_map_, 1e-6, 1e-6));
}

TEST_F(MapFrameTest, WhatIsMissingIsSaid) {
  const auto missing = [&](double now_s) {
    return complaint([&] { frame_.odom_from_map(second(now_s)); });
  };
  EXPECT_THAT(missing(101.0), HasSubstr("no SLAM_POSE"));
  frame_.on_slam_pose(second(100.5), Pose2{}, second(101.0));
  EXPECT_THAT(missing(101.0), HasSubstr("no odometry"));
  add_odometry(100.0, 101.0);
  EXPECT_EQ(missing(101.0), "");
  EXPECT_THAT(missing(103.5), HasSubstr("no SLAM_POSE"));
  frame_.on_slam_pose(second(103.4), std::nullopt, second(103.5));
  EXPECT_THAT(missing(103.5), HasSubstr("SLAM is lost"));
}

TEST_F(MapFrameTest, APoseBeforeABasesRestartSaysNothing) {
  add_odometry(100.0, 110.0);
  frame_.on_slam_pose(second(110.0), Pose2{}, second(110.0));
  EXPECT_EQ(complaint([&] { frame_.odom_from_map(second(110.1)); }), "");
  frame_.on_odometry({second(110.1), {}});
  EXPECT_NE(complaint([&] { frame_.odom_from_map(second(110.1)); }), "");
}

}  // namespace
}  // namespace marco::teleop
