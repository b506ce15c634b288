#include "recordings/ros/ros_reader.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "tests/support/ros_robot.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::Recorded;
using ::marco::testing::ScanShape;
using Robot = ::marco::testing::RosRobot;
using ::testing::Contains;
using ::testing::HasSubstr;

TEST(RosReader, TakesTheLasersPlaceFromTransformsThatWereLatchedHoursBefore) {
  Robot robot;
  robot.transform(-15000.0 + 20000.0, "base_link", "laser",
                  make_pose3({0.1, 0.2, 0.3}, std::numbers::pi, 0.0, 1.0), "/tf_static");
  for (int i = 0; i < 10; ++i) robot.scan(20000.0 + 0.1 * i);
  for (int i = 0; i < 10; ++i) robot.odometry(20000.0 + 0.1 * i, {0.1 * i, 0.0, 0.0});
  const Recorded recorded = robot.recorded();
  ASSERT_EQ(recorded.infos.size(), 1U);
  const Pose3& place = recorded.infos[0].parent_from_sensor;
  EXPECT_NEAR(place.translation().y(), 0.2, 1e-9);
  EXPECT_NEAR(place.linear()(2, 2), -1.0, 1e-9);
  EXPECT_EQ(recorded.scans.size(), 10U);
  EXPECT_NEAR(recorded.odometry.at(9).odom_from_robot.x_m, 0.9, 1e-12);
  EXPECT_NEAR(recorded.odometry.at(9).yaw_rate_rad_per_s, 0.3, 1e-12);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("upside down")));
}

TEST(RosReader, BelievesTheCountAndTheStepOfBeams) {
  Robot robot;
  for (int i = 0; i < 3; ++i) robot.scan(1.0 + i);
  const Recorded recorded = robot.recorded();
  EXPECT_NEAR(recorded.scans.at(0).bearing_rad(4), 1.0, 1e-6);  // not angle_max, 1.5
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("no transform to laser")));
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("no odometry")));
}

TEST(RosReader, OdometryMayBeATransform) {
  Robot robot;
  robot.transform(1.0, "base_link", "laser", Pose3::Identity());
  for (int i = 0; i < 10; ++i) {
    robot.scan(1.0 + 0.1 * i);
    robot.transform(1.0 + 0.1 * i, "odom", "base_link", lift({0.1 * i, 0.0, 0.0}));
    robot.transform(1.0 + 0.1 * i, "map", "odom", lift({5.0, 0.1 * i, 0.0}));  // of another SLAM
  }
  const Recorded recorded = robot.recorded();
  ASSERT_EQ(recorded.odometry.size(), 10U);
  EXPECT_NEAR(recorded.odometry[9].odom_from_robot.x_m, 0.9, 1e-12);
  EXPECT_NEAR(recorded.odometry[9].odom_from_robot.y_m, 0.0, 1e-12);
}

TEST(RosReader, TruthIsNoOdometry) {
  Robot robot;
  robot.transform(1.0, "base_link", "laser", Pose3::Identity());
  for (int i = 0; i < 10; ++i) {
    robot.scan(1.0 + 0.1 * i);
    robot.odometry(1.0 + 0.1 * i, {0.1 * i, 0, 0});
    for (int k = 0; k < 5; ++k) {
      robot.odometry(1.0 + 0.1 * i + 0.02 * k, {7, 0, 0}, 0.0, "/base_pose_ground_truth", "world");
    }
  }
  RosOptions options;
  options.truth = "/base_pose_ground_truth";
  const Recorded recorded = robot.recorded(options);
  EXPECT_EQ(recorded.odometry.size(), 10U);
  ASSERT_EQ(recorded.truth.size(), 50U);
  EXPECT_NEAR(recorded.truth[0].world_from_robot.x_m, 7.0, 1e-12);
}

TEST(RosReader, MovesStampsOfAnotherComputerToTheLasersClock) {
  Robot robot;
  for (int i = 0; i < 10; ++i) {
    robot.scan(1000.0 + 0.1 * i);
    robot.odometry(4600.0 + 0.1 * i, {0.1 * i, 0, 0}, -3600.0);
  }
  const Recorded recorded = robot.recorded();
  EXPECT_NEAR(recorded.odometry.at(3).utime.seconds(), 1000.3, 1e-6);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("3600.000 s ahead of the laser's")));
}

TEST(RosReader, SimulatedTimeNeedsNoOptions) {
  Robot robot;
  robot.late_s = 1.6e9;
  for (int i = 0; i < 10; ++i) {
    robot.scan(1.0 + 0.1 * i);
    robot.odometry(1.0 + 0.1 * i, {0.1 * i, 0, 0});
  }
  const Recorded recorded = robot.recorded();
  EXPECT_NEAR(recorded.scans.at(0).utime.seconds(), 1.0, 1e-6);
  EXPECT_NEAR(recorded.odometry.at(0).utime.seconds(), 1.0, 1e-6);
}

TEST(RosReader, ANoddingLaserIsOnAPanTiltAndAFixedOneLeads) {
  Robot robot;
  robot.transform(1.0, "base_link", "front", make_pose3({0.2, 0, 0.1}));
  for (int i = 0; i < 20; ++i) {
    const double tilt_rad = 0.3 * std::sin(0.5 * i);
    robot.transform(1.0 + 0.1 * i, "base_link", "tilting", make_pose3({0.4, 0, 0.6}, 0, tilt_rad));
    robot.scan(1.0 + 0.1 * i, {.frame = "tilting"}, "/a_tilt_scan");
    robot.scan(1.01 + 0.1 * i, {.frame = "front"}, "/scan");
    robot.odometry(1.0 + 0.1 * i, {0, 0, 0});
  }
  const Recorded recorded = robot.recorded();
  ASSERT_EQ(recorded.infos.size(), 3U);
  EXPECT_EQ(recorded.infos[0].channel, "PANTILT_STATE");
  EXPECT_NEAR(recorded.infos[0].parent_from_sensor.translation().z(), 0.6, 1e-9);
  EXPECT_EQ(recorded.infos[1].channel, "LIDAR");
  EXPECT_EQ(recorded.infos[1].mount, SensorInfo::Mount::robot);
  EXPECT_EQ(recorded.infos[2].channel, "LIDAR_A_TILT_SCAN");
  EXPECT_EQ(recorded.infos[2].mount, SensorInfo::Mount::pantilt);
  EXPECT_EQ(recorded.scans.at(0).channel, "LIDAR");
  ASSERT_EQ(recorded.pantilt.size(), 20U);
  EXPECT_NEAR(recorded.pantilt[3].tilt_rad, -0.3 * std::sin(1.5), 1e-9);  // looks up: positive
}

TEST(RosReader, GyroscopesInDegreesAreRecognised) {
  Robot robot;
  for (int i = 0; i < 10; ++i) {
    robot.scan(1.0 + 0.1 * i);
    robot.imu(1.0 + 0.1 * i, 90.0);
  }
  const Recorded recorded = robot.recorded();
  EXPECT_NEAR(recorded.imu.at(0).angular_velocity_rad_per_s.z(), std::numbers::pi / 2, 1e-9);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("degrees per second")));
}

TEST(RosReader, ALaserThatSeesAllRoundTellsTheTimesOfItsBeams) {
  ScanShape round;
  round.step_rad = static_cast<float>(std::numbers::pi / 180.0);
  round.time_step_s = 0.1F / 360.0F;
  round.ranges_m.assign(360, 2.0F);
  Robot robot;
  for (int i = 0; i < 10; ++i) robot.scan(1.0 + 0.1 * i, round);
  RosOptions options;
  options.clockwise = true;
  options.stamp = "last";
  const Recorded recorded = robot.recorded(options);
  const LaserScan& scan = recorded.scans.at(0);
  EXPECT_EQ(scan.channel, "LIDAR_RAW");
  EXPECT_NEAR(scan.time_offsets_s.at(359), 0.1 * 359 / 360, 1e-6);
  EXPECT_NEAR(scan.bearing_rad(0), 1.0, 1e-6);
  EXPECT_LT(scan.bearing_rad(1), 1.0);
  EXPECT_NEAR(scan.utime.seconds(), 0.9, 0.001);
}

TEST(RosReader, SaysWhatThereIsWhereThereIsNoLaser) {
  Robot robot;
  robot.other("/rosout", "rosgraph_msgs/Log");
  EXPECT_THAT([&] { robot.recorded(); },
              ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("no laser: it holds")));
  Robot named;
  named.scan(1.0);
  named.scan(2.0);
  RosOptions options;
  options.laser = "/other";
  EXPECT_THAT([&] { named.recorded(options); },
              ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("/scan")));
}

TEST(RosReader, CountsMessagesThatDoNotFitTheirType) {
  Robot robot;
  for (int i = 0; i < 5; ++i) robot.scan(1.0 + i);
  robot.other("/scan", "sensor_msgs/LaserScan");
  const Recorded recorded = robot.recorded();
  EXPECT_EQ(recorded.scans.size(), 5U);
  ASSERT_EQ(recorded.report.dropped.size(), 1U);
  EXPECT_EQ(recorded.report.places.begin()->second, "/scan");
}

}  // namespace
}  // namespace marco::ros
