#include "recordings/ros/ros_reader.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "tests/support/recorded.hpp"
#include "tests/support/ros_wire.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::MemorySource;
using ::marco::testing::read_all;
using ::marco::testing::Recorded;
using ::marco::testing::RosWriter;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr auto kForm = RosWriter::Form::cdr;

struct ScanShape {
  std::string frame = "laser";
  float first_rad = -1.0F, step_rad = 0.5F, time_step_s = 0.0F;
  std::vector<float> ranges_m{1.0F, 2.0F, 3.0F, 4.0F, 5.0F};
};

/// A robot's recording, put together message by message.
class Robot {
 public:
  void scan(double stamp_s, const ScanShape& shape = {}, const std::string& topic = "/scan") {
    RosWriter out(kForm);
    const float last_rad =
        shape.first_rad + shape.step_rad * static_cast<float>(shape.ranges_m.size());
    out.header(stamp_s, shape.frame);
    out.numbers(std::vector<float>{shape.first_rad, last_rad, shape.step_rad, shape.time_step_s,
                                   0.1F, 0.05F, 10.0F});
    out.number(static_cast<uint32_t>(shape.ranges_m.size())).numbers(shape.ranges_m);
    out.number(uint32_t{0});
    source_->add(topic, "sensor_msgs/LaserScan", stamp_s + late_s, out.bytes());
  }
  void odometry(double stamp_s,
                const Pose2& pose,
                double delay_s = 0.0,
                const std::string& topic = "/odom",
                const std::string& frame = "odom") {
    RosWriter out(kForm);
    out.header(stamp_s, frame).text("base_link");
    write(out, lift(pose));
    out.numbers(std::vector<double>(36, 0.0));
    out.numbers(std::vector<double>{0.4, 0, 0, 0, 0, 0.3});
    out.numbers(std::vector<double>(36, 0.0));
    source_->add(topic, "nav_msgs/Odometry", stamp_s + delay_s + late_s, out.bytes());
  }
  void transform(double stamp_s,
                 const std::string& parent,
                 const std::string& child,
                 const Pose3& pose,
                 const std::string& topic = "/tf") {
    RosWriter out(kForm);
    out.number(uint32_t{1}).header(stamp_s, parent).text(child);
    write(out, pose);
    source_->add(topic, "tf2_msgs/TFMessage", stamp_s + late_s, out.bytes());
  }
  void joints(double stamp_s, const std::map<std::string, double>& positions_rad) {
    RosWriter out(kForm);
    out.header(stamp_s, "").number(static_cast<uint32_t>(positions_rad.size()));
    for (const auto& [name, position] : positions_rad) out.text(name);
    out.number(static_cast<uint32_t>(positions_rad.size()));
    for (const auto& [name, position] : positions_rad) out.number(position);
    out.number(uint32_t{0}).number(uint32_t{0});
    source_->add("/joint_states", "sensor_msgs/JointState", stamp_s + late_s, out.bytes());
  }
  void imu(double stamp_s, double yaw_rate) {
    RosWriter out(kForm);
    out.header(stamp_s, "imu").numbers(std::vector<double>(4 + 9, 0.0));
    out.numbers(std::vector<double>{0, 0, yaw_rate}).numbers(std::vector<double>(9, 0.0));
    out.numbers(std::vector<double>{0, 0, 9.8}).numbers(std::vector<double>(9, 0.0));
    source_->add("/imu", "sensor_msgs/Imu", stamp_s, out.bytes());
  }
  void other(const std::string& topic, const std::string& type) {
    source_->add(topic, type, 1.0, {});
  }

  Recorded recorded(const RosOptions& options = {}) {
    return read_all(*open_ros(std::move(source_), options));
  }

  double late_s = 0.0;  ///< of the recorder's clock

 private:
  static void write(RosWriter& out, const Pose3& pose) {
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d t = pose.translation();
    out.numbers(std::vector<double>{t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
  }

  std::unique_ptr<MemorySource> source_ = std::make_unique<MemorySource>();
};

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
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("no transform tells where laser is")));
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

// Its joint is not in tf.
TEST(RosReader, ATiltingLaserIsTurnedByItsJointState) {
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
TEST(RosReader, AJointThatIsNotTheLasersIsNotItsPanTilt) {
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

TEST(RosReader, WheelsAreOdometryWhereTheirSizeIsKnown) {
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

// As simulators do it: noise is added to what returned nothing, and cut off at the limit.
TEST(RosReader, RangesThatPileUpAtTheLimitAreNoReturn) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> wall_m(1.0F, 6.0F);
  std::normal_distribution<float> noise_m(0.0F, 0.01F);
  Robot robot;
  for (int i = 0; i < 50; ++i) {
    ScanShape shape;
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
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("taken for no return")));
}

// A robot that stands sees the same walls again and again.
TEST(RosReader, WallsThatPileUpBelowTheLimitStay) {
  Robot robot;
  for (int i = 0; i < 50; ++i) robot.scan(1.0 + 0.1 * i);
  EXPECT_EQ(robot.recorded().infos.at(0).range_max_m, 10.0);
}

TEST(RosReader, GyroscopesInDegreesAreRecognised) {
  Robot robot;
  for (int i = 0; i < 10; ++i) {
    robot.scan(1.0 + 0.1 * i);
    robot.imu(1.0 + 0.1 * i, 90.0);
  }
  const Recorded recorded = robot.recorded();
  EXPECT_NEAR(recorded.imu.at(0).angular_velocity_rad_per_s.z(), std::numbers::pi / 2, 1e-9);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("degrees a second")));
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
