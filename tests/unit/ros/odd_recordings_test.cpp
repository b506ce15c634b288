// What recorders and drivers do that no definition says.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/ros_robot.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::Recorded;
using ::marco::testing::ScanShape;
using Robot = ::marco::testing::RosRobot;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// As simulators do it: noise is added to what returned nothing, and cut off at the limit.
TEST(OddRecordings, RangesThatPileUpAtTheLimitAreNoReturn) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> wall_m(1.0F, 6.0F);
  std::normal_distribution<float> noise_m(0.0F, 0.01F);
  Robot robot;
  for (int i = 0; i < 50; ++i) {
    ScanShape shape;
    shape.step_rad = 0.01F;
    shape.ranges_m.clear();
    for (int beam = 0; beam < 180; ++beam) {
      shape.ranges_m.push_back(beam % 3 == 0 ? std::min(10.0F, 10.0F + noise_m(random))
                                             : wall_m(random));
    }
    robot.scan(1.0 + 0.1 * i, shape);
  }
  const Recorded recorded = robot.recorded();
  EXPECT_LT(recorded.infos.at(0).range_max_m, 9.97);
  EXPECT_GT(recorded.infos.at(0).range_max_m, 9.5);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("treated as no return")));
}

// A robot that stands sees the same walls again and again.
TEST(OddRecordings, WallsThatPileUpBelowTheLimitStay) {
  Robot robot;
  for (int i = 0; i < 50; ++i) robot.scan(1.0 + 0.1 * i);
  EXPECT_EQ(robot.recorded().infos.at(0).range_max_m, 10.0);
}

// A laser without a limit: what stands beyond is not known.
TEST(OddRecordings, ALimitOfInfinityIsNone) {
  Robot robot;
  ScanShape shape;
  shape.range_max_m = std::numeric_limits<float>::infinity();
  for (int i = 0; i < 50; ++i) robot.scan(1.0 + 0.1 * i, shape);
  EXPECT_EQ(robot.recorded().infos.at(0).range_max_m, SensorInfo{}.range_max_m);
}

TEST(OddRecordings, WithoutAnIncrementTheAnglesCount) {
  ScanShape shape;
  shape.told_step_rad = 0.0F;
  Robot robot;
  for (int i = 0; i < 3; ++i) robot.scan(1.0 + i, shape);
  const Recorded recorded = robot.recorded();
  ASSERT_EQ(recorded.scans.size(), 3U);
  EXPECT_NEAR(recorded.scans[0].bearing_step_rad, 2.5 / 4.0, 1e-6);  // angle_max - angle_min
}

TEST(OddRecordings, ScansOfWhichAllBeamsLookOneWayAreDropped) {
  ScanShape shape;
  shape.step_rad = 0.0F;
  shape.told_step_rad = 0.0F;
  Robot robot;
  for (int i = 0; i < 3; ++i) robot.scan(1.0 + i, shape);
  const Recorded recorded = robot.recorded();
  EXPECT_TRUE(recorded.scans.empty());
  EXPECT_EQ(recorded.report.dropped.at("scan with all beams in one direction"), 3);
}

TEST(OddRecordings, ScansOfErrorsAloneAreScans) {
  ScanShape shape;
  shape.ranges_m.assign(5, std::nanf(""));
  Robot robot;
  for (int i = 0; i < 3; ++i) robot.scan(1.0 + i, shape);
  EXPECT_EQ(robot.recorded().scans.size(), 3U);
}

// tf of ROS 1 began names with a slash, and its messages did not.
TEST(OddRecordings, ASlashBeforeAFrameIsNone) {
  Robot robot;
  robot.transform(1.0, "/base_link", "/laser", make_pose3({0.3, 0, 0}));
  for (int i = 0; i < 3; ++i) robot.scan(1.0 + i, {.frame = "laser"});
  EXPECT_NEAR(robot.recorded().infos.at(0).parent_from_sensor.translation().x(), 0.3, 1e-12);
}

TEST(OddRecordings, OfTwoLasersWhosePlacesNobodyTellsOneIsUsed) {
  Robot robot;
  for (int i = 0; i < 10; ++i) {
    robot.scan(1.0 + 0.1 * i, {.frame = "a"}, "/front");
    robot.scan(1.0 + 0.1 * i, {.frame = "b"}, "/back");
  }
  const Recorded recorded = robot.recorded();
  EXPECT_EQ(recorded.infos.size(), 1U);
  EXPECT_THAT(recorded.report.notes,
              Contains(HasSubstr("laser /front is ignored: no transform to a")));
}

// The computer of its driver is three seconds ahead.
TEST(OddRecordings, TheClockOfAJointIsPutRight) {
  Robot robot;
  robot.transform(1.0, "base_link", "front", make_pose3({0.2, 0, 0.1}));
  for (int i = 0; i < 20; ++i) {
    robot.late_s = 0.0;
    robot.scan(1.0 + 0.1 * i, {.frame = "tilting"}, "/tilt_scan");
    robot.scan(1.0 + 0.1 * i, {.frame = "front"}, "/scan");
    robot.late_s = -3.0;
    robot.transform(4.0 + 0.1 * i, "base_link", "tilting",
                    make_pose3({0.4, 0, 0.6}, 0, 0.3 * std::sin(0.5 * i)));
  }
  const Recorded recorded = robot.recorded();
  ASSERT_EQ(recorded.pantilt.size(), 20U);
  EXPECT_NEAR(recorded.pantilt[5].utime.seconds(), 1.5, 1e-6);
  EXPECT_THAT(recorded.report.notes,
              Contains(HasSubstr("the clock of tf from base_link to tilting is 3.000 s ahead")));
}

// Two seconds of ours for one of the simulation; its odometry begins after twenty.
TEST(OddRecordings, TimeThatIsSimulatedSlowlyIsOneClock) {
  Robot robot;
  for (int i = 0; i < 80; ++i) {
    const double stamp_s = 1.0 + 0.5 * i;
    robot.late_s = 1.6e9 + stamp_s;
    robot.scan(stamp_s);
    if (stamp_s > 20.0) robot.odometry(stamp_s, {0.1 * i, 0, 0});
  }
  const Recorded recorded = robot.recorded();
  EXPECT_NEAR(recorded.odometry.at(0).utime.seconds(), 20.5, 1e-6);
  EXPECT_THAT(recorded.report.notes, Not(Contains(HasSubstr("the clock of"))));
}

TEST(OddRecordings, WithoutAStampTheTimeOfReceiptCountsByTheLasersClock) {
  Robot robot;
  robot.late_s = 1.6e9;
  for (int i = 0; i < 10; ++i) {
    robot.scan(1.0 + 0.1 * i);
    robot.odometry(0.0, {0.1 * i, 0, 0}, 1.0 + 0.1 * i);
  }
  const Recorded recorded = robot.recorded();
  EXPECT_NEAR(recorded.odometry.at(3).utime.seconds(), 1.3, 1e-6);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("/odom: 10 of 10 messages have no stamp")));
}

}  // namespace
}  // namespace marco::ros
