#include "common/pose2.hpp"

#include <gtest/gtest.h>

#include <random>

#include "common/samples.hpp"
#include "tests/support/matchers.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;

constexpr double kPi = std::numbers::pi;

TEST(Pose2, AnglesAreNormalizedIntoHalfOpenInterval) {
  EXPECT_DOUBLE_EQ(normalize_angle(kPi), -kPi);
  EXPECT_DOUBLE_EQ(normalize_angle(-kPi), -kPi);
  EXPECT_NEAR(normalize_angle(7.0 * kPi + 0.1), -kPi + 0.1, 1e-12);
  EXPECT_DOUBLE_EQ(normalize_angle(0.3), 0.3);
}

TEST(Pose2, ProductMapsPointsInTwoSteps) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-3.0, 3.0);
  for (int i = 0; i < 100; ++i) {
    const Pose2 a_from_b{uniform(random), uniform(random), uniform(random)};
    const Pose2 b_from_c{uniform(random), uniform(random), uniform(random)};
    const Eigen::Vector2d point_in_c(uniform(random), uniform(random));
    const Eigen::Vector2d once = (a_from_b * b_from_c) * point_in_c;
    const Eigen::Vector2d twice = a_from_b * (b_from_c * point_in_c);
    EXPECT_LT((once - twice).norm(), 1e-12);
    EXPECT_THAT(a_from_b * a_from_b.inverse(), IsNear(Pose2{}, 1e-12, 1e-12));
    EXPECT_THAT(a_from_b * between(a_from_b, b_from_c), IsNear(b_from_c, 1e-12, 1e-12));
  }
}

TEST(Pose2, InterpolationTakesTheShorterWayRound) {
  const Pose2 middle = interpolate({0, 0, kPi - 0.1}, {2, 4, -kPi + 0.3}, 0.5);
  EXPECT_THAT(middle, IsNear(Pose2{1, 2, -kPi + 0.1}, 1e-12, 1e-12));
}

TEST(Pose3, PanTiltLooksUpAndLeftAndCarriesItsLeverArm) {
  SensorInfo base;
  base.parent_from_sensor = make_pose3({0.1, 0.0, 0.5});
  base.tilt_axis_m = {0.0, 0.0, 0.02};
  SensorInfo laser;
  laser.parent_from_sensor = make_pose3({0.045, 0.0, 0.008});
  const Pose3 robot_from_laser =
      robot_from_pantilt_sensor(base, laser, deg_to_rad(90), deg_to_rad(90));
  // Panned left and tilted straight up: ahead of the laser is up, and the 45 mm lever points up
  // too.
  const Eigen::Vector3d ahead = robot_from_laser.linear() * Eigen::Vector3d::UnitX();
  EXPECT_LT((ahead - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((robot_from_laser.translation() - Eigen::Vector3d(0.1, -0.008, 0.565)).norm(), 1e-12);
}

}  // namespace
}  // namespace marco
