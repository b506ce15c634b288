#include "common/input/sensor_calibration.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;

// Wheels 0.4 m apart that really go `left_m` and `right_m`; what they count is read by a robot
// that believes in scales of 1.
ArcMotion counted_by(double left_m, double right_m, const OdometryCalibration& calibration) {
  const double left = left_m / calibration.left_scale, right = right_m / calibration.right_scale;
  return {0.5 * (left + right) * calibration.forward_sign, 0.0,
          (right - left) / kCountedTrackM * calibration.turn_sign};
}

TEST(OdometryCalibration, GivesBackWhatTheWheelsDid) {
  OdometryCalibration calibration;
  calibration.forward_sign = -1.0;
  calibration.turn_sign = -1.0;
  calibration.left_scale = 0.9;
  calibration.right_scale = 1.2;
  calibration.track_scale = 1.5;
  const ArcMotion found = calibration.corrected(counted_by(0.3, 0.5, calibration));
  EXPECT_NEAR(found.ahead_m, 0.4, 1e-12);
  EXPECT_NEAR(found.left_m, 0.0, 1e-12);
  EXPECT_NEAR(found.turn_rad, 0.2 / 0.6, 1e-12);
}

TEST(OdometryCalibration, CountsAtTheAxle) {
  OdometryCalibration calibration;
  calibration.axle_x_m = -0.3;
  calibration.axle_yaw_deg = 20.0;
  calibration.left_scale = 0.8;
  // The axle's way, and that of the frame of the odometry, which is fixed to it.
  const Pose2 robot_from_axle = calibration.robot_from_axle();
  const Pose2 counted = ArcMotion{0.5, 0.0, 0.3}.moved(), scaled = [&] {
    OdometryCalibration wheels;
    wheels.left_scale = 0.8;
    return wheels.corrected({0.5, 0.0, 0.3}).moved();
  }();
  const ArcMotion robot = ArcMotion::of(robot_from_axle * counted * robot_from_axle.inverse());
  EXPECT_THAT(calibration.corrected(robot).moved(),
              IsNear(robot_from_axle * scaled * robot_from_axle.inverse(), 1e-12, 1e-12));
}

TEST(OdometryCorrector, ScalesATrackStepByStep) {
  OdometryCalibration calibration;
  calibration.left_scale = calibration.right_scale = 2.0;
  calibration.late_s = 0.25;
  OdometryCorrector corrector;
  Pose2 at{5.0, 6.0, 0.3}, twice = at;
  for (int i = 0; i < 50; ++i) {
    const OdometrySample found =
        corrector.corrected({Utime::from_seconds(100 + 0.1 * i), at, 0.5, 1.0}, calibration);
    EXPECT_NEAR(found.velocity_m_per_s, 1.0, 1e-12);
    EXPECT_NEAR(found.yaw_rate_rad_per_s, 2.0, 1e-12);
    EXPECT_EQ(found.utime, Utime::from_seconds(99.75 + 0.1 * i));
    EXPECT_THAT(found.odom_from_robot, IsNear(twice, 1e-9, 1e-9));
    at = at * ArcMotion{0.05, 0.01, 0.1}.moved();
    twice = twice * ArcMotion{0.1, 0.02, 0.2}.moved();
  }
}

TEST(OdometryCorrector, ChangesNothingByDefault) {
  OdometrySample sample{Utime::from_us(7), {0.1, 0.2, 0.3}, 0.4, 0.5, 6, 7};
  OdometryCorrector corrector;
  corrector.corrected(sample, {});
  sample.odom_from_robot = {1.0 / 3.0, 2.0 / 3.0, 0.7};
  const OdometrySample found = corrector.corrected(sample, {});
  EXPECT_EQ(found.odom_from_robot.vector(), sample.odom_from_robot.vector());
  EXPECT_EQ(found.utime, sample.utime);
}

TEST(GyroCalibration, TakesOffTheBias) {
  ImuSample sample;
  sample.utime = Utime::from_us(5'000'000);
  sample.angular_velocity_rad_per_s.z() = 10.0;
  const ImuSample found = GyroCalibration{-0.1, 2.0, 0.5}.corrected(sample);
  EXPECT_NEAR(found.angular_velocity_rad_per_s.z(), -0.8, 1e-12);
  EXPECT_EQ(found.utime.us, 4'500'000);
}

TEST(LaserCalibration, PutsALaserUpsideDown) {
  SensorInfo said;
  said.channel = "LIDAR";
  said.parent_from_sensor = make_pose3({0.0, 0.0, 0.7});
  const LaserCalibration calibration{"LIDAR", 0.3, -0.1, 90.0, true};
  const SensorInfo found = calibration.corrected(said);
  // Ahead of the laser is left of the robot, and left of the laser is ahead of it: mirrored.
  const Eigen::Vector3d ahead = found.parent_from_sensor * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d left = found.parent_from_sensor * Eigen::Vector3d::UnitY();
  EXPECT_NEAR((ahead - Eigen::Vector3d(0.3, 0.9, 0.7)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((left - Eigen::Vector3d(1.3, -0.1, 0.7)).norm(), 0.0, 1e-12);
  said.channel = "LIDAR_REAR";
  EXPECT_TRUE(calibration.corrected(said).parent_from_sensor.isApprox(said.parent_from_sensor));
  said.channel = "LIDAR";
  said.mount = SensorInfo::Mount::pantilt;
  EXPECT_TRUE(calibration.corrected(said).parent_from_sensor.isApprox(said.parent_from_sensor));
}

// A laser that looks down by 5 degrees does so at its true place, too, and nothing is put twice.
TEST(LaserCalibration, KeepsHeightAndTiltAndWhatIsCorrectedAlready) {
  const LaserCalibration calibration{"LIDAR", 0.3, -0.1, 90.0, false};
  SensorInfo said;
  said.channel = "LIDAR";
  said.parent_from_sensor = lift({0.1, 0.2, deg_to_rad(-30.0)});
  said.parent_from_sensor.translation().z() = 0.7;
  said.parent_from_sensor.rotate(Eigen::AngleAxisd(deg_to_rad(5.0), Eigen::Vector3d::UnitY()));
  const SensorInfo found = calibration.corrected(said);
  EXPECT_THAT(flatten(found.parent_from_sensor),
              IsNear(Pose2{0.3, -0.1, deg_to_rad(90.0)}, 1e-12, 1e-12));
  EXPECT_NEAR(found.parent_from_sensor.translation().z(), 0.7, 1e-12);
  EXPECT_NEAR(found.parent_from_sensor.linear()(2, 0), -std::sin(deg_to_rad(5.0)), 1e-12);
  EXPECT_TRUE(calibration.corrected(found).parent_from_sensor.isApprox(found.parent_from_sensor));
  const LaserCalibration turned{"LIDAR", 0.3, -0.1, 90.0, true};
  const SensorInfo upside_down = turned.corrected(said);
  EXPECT_LT(upside_down.parent_from_sensor.linear()(2, 2), -0.99);
  EXPECT_TRUE(
      turned.corrected(upside_down).parent_from_sensor.isApprox(upside_down.parent_from_sensor));
}

}  // namespace
}  // namespace marco
