#include <gmock/gmock.h>

#include <numbers>

#include "tests/support/ros_robot.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::Recorded;
using Robot = ::marco::testing::RosRobot;
using ::testing::Contains;
using ::testing::HasSubstr;

// Its joint is not in tf.
TEST(JointStates, ATiltingLaserIsTurnedByItsJointState) {
  Robot robot;
  robot.transform(1.0, "base_link", "tilting", make_pose3({0.4, 0, 0.6}));
  for (int i = 0; i < 20; ++i) {
    robot.joints(1.0 + 0.1 * i, {{"laser_tilt_joint", 0.02 * i}, {"wheel_left_joint", 1.0 * i}});
    robot.scan(1.0 + 0.1 * i, {.frame = "tilting"});
  }
  const Recorded recorded = robot.recorded();
  ASSERT_EQ(recorded.infos.size(), 2U);
  EXPECT_NEAR(recorded.infos[0].parent_from_sensor.translation().z(), 0.6, 1e-9);
  EXPECT_EQ(recorded.infos[1].mount, SensorInfo::Mount::pantilt);
  EXPECT_NEAR(recorded.infos[1].parent_from_sensor.translation().norm(), 0.0, 1e-9);
  ASSERT_EQ(recorded.pantilt.size(), 20U);
  EXPECT_NEAR(recorded.pantilt[5].tilt_rad, -0.1, 1e-12);  // what looks up is positive
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("its pan-tilt is laser_tilt_joint of")));
}

// It moves a camera.
TEST(JointStates, AJointThatIsNotTheLasersIsNotItsPanTilt) {
  Robot robot;
  for (int i = 0; i < 20; ++i) {
    robot.joints(1.0 + 0.1 * i, {{"camera_tilt_joint", 0.02 * i}});
    robot.scan(1.0 + 0.1 * i);
  }
  const Recorded recorded = robot.recorded();
  ASSERT_EQ(recorded.infos.size(), 1U);
  EXPECT_TRUE(recorded.pantilt.empty());
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("not used: /joint_states")));
}

TEST(JointStates, WheelsAreOdometryWhereTheirSizeIsKnown) {
  const auto drive = [](const RosOptions& options) {
    Robot robot;
    for (int i = 0; i <= 20; ++i) {
      // A quarter of a turn to the left, about a point 0.5 m beside the robot.
      robot.joints(1.0 + 0.1 * i,
                   {{"wheel_left_joint", 7.0 + 0.1 * i}, {"wheel_right_joint", 0.15 * i}});
      robot.scan(1.0 + 0.1 * i);
    }
    return robot.recorded(options);
  };
  EXPECT_THAT(drive({}).report.notes, Contains(HasSubstr("ros.wheel_radius_m and")));
  RosOptions options;
  options.wheel_radius_m = std::numbers::pi / 10.0;
  options.wheel_track_m = 0.2;
  const Recorded recorded = drive(options);
  ASSERT_EQ(recorded.odometry.size(), 21U);
  const Pose2& end = recorded.odometry.back().odom_from_robot;
  EXPECT_NEAR(end.theta_rad, std::numbers::pi / 2.0, 1e-9);
  EXPECT_NEAR(end.x_m, 0.5, 0.02);  // in steps of 4.5 deg
  EXPECT_NEAR(end.y_m, 0.5, 0.02);
}

}  // namespace
}  // namespace marco::ros
