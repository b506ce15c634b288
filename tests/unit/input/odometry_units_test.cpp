#include "common/input/odometry_units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

namespace marco {
namespace {

using ::testing::HasSubstr;

// What is said of a minute of driving at 50 Hz, each sample changed by `change`.
std::string said_of(const std::function<void(OdometrySample&, int)>& change) {
  OdometryUnits units;
  std::string said;
  Pose2 pose;
  for (int i = 0; i < 3000; ++i) {
    const double time_s = 0.02 * i;
    pose = pose * Pose2{0.02 * 0.3, 0.0, 0.02 * 0.6 * std::sin(0.5 * time_s)};
    OdometrySample sample;
    sample.utime = Utime::from_seconds(100.0 + time_s);
    sample.odom_from_robot = pose;
    change(sample, i);
    said = units.look(sample).value_or("");
  }
  return said;
}

TEST(OdometryUnits, MillimetresAndDegreesAreRecognised) {
  const auto to_degrees = [](OdometrySample& sample, int) {
    sample.odom_from_robot.theta_rad = rad_to_deg(sample.odom_from_robot.theta_rad);
  };
  EXPECT_THAT(said_of(to_degrees), HasSubstr("is its heading in degrees"));
  EXPECT_THAT(said_of([](OdometrySample& sample, int) {
                sample.odom_from_robot.x_m *= 1000.0;
                sample.odom_from_robot.y_m *= 1000.0;
              }),
              HasSubstr("drives at 300 m/s"));
}

TEST(OdometryUnits, MetresAndRadiansAreNot) {
  EXPECT_EQ(said_of([](OdometrySample&, int) {}), "");
  // A robot that spins at 5 rad/s.
  EXPECT_EQ(said_of([](OdometrySample& sample, int i) {
              sample.odom_from_robot.theta_rad = normalize_angle(0.1 * i);
            }),
            "");
}

// Whatever its cause: restarts of the board, and stamps that are set on arrival.
TEST(OdometryUnits, JumpsAndBurstsOfARightOdometryAreForgiven) {
  EXPECT_EQ(said_of([](OdometrySample& sample, int i) {
              if (i / 500 % 2 == 1) sample.odom_from_robot = Pose2{40.0, 3.0, 2.0};
            }),
            "");
  EXPECT_EQ(said_of([](OdometrySample& sample, int i) {
              sample.odom_from_robot.theta_rad = normalize_angle(0.06 * i);
              sample.utime = Utime::from_seconds(100.0 + 0.2 * (i / 10) + 1e-4 * (i % 10));
            }),
            "");
}

// At 3 m/s every step counts as motion.
OdometrySample fast_sample(int i) {
  OdometrySample sample;
  sample.utime = Utime::from_seconds(100.0 + 0.02 * i);
  sample.odom_from_robot.x_m = 0.06 * i;
  return sample;
}

// A base's firmware is changed, say; what was right for minutes must not hide it for as long.
TEST(OdometryUnits, AreTakenForWrongSoonAfterManyRightSteps) {
  OdometryUnits units;
  for (int i = 0; i < 2500; ++i) EXPECT_FALSE(units.look(fast_sample(i))) << i;
  for (int i = 2500; i < 2700; ++i) {
    OdometrySample sample = fast_sample(i);
    sample.odom_from_robot.x_m *= 1000.0;
    units.look(sample);
  }
  EXPECT_TRUE(units.verdict());
}

TEST(OdometryUnits, OneWrongSampleOfFiftyIsForgivenForEver) {
  OdometryUnits units;
  for (int i = 0; i < 3000; ++i) {
    OdometrySample sample = fast_sample(i);
    if (i % 50 == 49) sample.odom_from_robot.y_m = 40.0;
    EXPECT_FALSE(units.look(sample)) << i;
  }
}

TEST(OdometryUnits, StepsOfLessThanFiveCentimetresAreNoMotion) {
  OdometryUnits units;
  for (int i = 0; i < 200; ++i) {
    OdometrySample sample;
    sample.utime = Utime::from_seconds(100.0 + 0.001 * i);
    sample.odom_from_robot.x_m = i % 2 == 0 ? 0.0 : 0.04;  // a wheel that rattles, read fast
    EXPECT_FALSE(units.look(sample)) << i;
  }
  for (int i = 200; i < 300; ++i) {
    OdometrySample sample;
    sample.utime = Utime::from_seconds(100.0 + 0.001 * i);
    sample.odom_from_robot.x_m = 0.06 * i;
    units.look(sample);
  }
  EXPECT_TRUE(units.verdict());
}

}  // namespace
}  // namespace marco
