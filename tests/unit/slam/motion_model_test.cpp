#include "slam/motion_model.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

MotionInput at(double seconds, std::optional<Pose2> odom = {}, std::optional<double> gyro = {}) {
  return {Utime::from_seconds(seconds), odom, gyro};
}

TEST(MotionModel, TheFirstScanKnowsNothing) {
  const MotionModel model;
  EXPECT_EQ(model.guess(at(1.0)).source, MotionGuess::Source::nothing);
}

TEST(MotionModel, OdometryGivesTheStepAndGrowsUncertainWithIt) {
  MotionModel model;
  model.update(at(1.0, Pose2{5, 5, 1.0}), {});
  const Pose2 step{0.5, 0.1, 0.2};
  const MotionGuess guess = model.guess(at(1.1, Pose2{5, 5, 1.0} * step));
  EXPECT_EQ(guess.source, MotionGuess::Source::odometry);
  EXPECT_THAT(guess.before_from_now, IsNear(step, 1e-12, 1e-12));
  const MotionGuess still = model.guess(at(1.1, Pose2{5, 5, 1.0}));
  EXPECT_LT(still.covariance(0, 0), guess.covariance(0, 0));
  EXPECT_LT(still.covariance(2, 2), guess.covariance(2, 2));
}

TEST(MotionModel, OdometryThatJumpsIsNotBelieved) {
  MotionModel model;
  model.update(at(1.0, Pose2{}), {});
  const MotionGuess guess = model.guess(at(1.1, Pose2{100, 0, 0}));
  EXPECT_NE(guess.source, MotionGuess::Source::odometry);
  EXPECT_LT(std::abs(guess.before_from_now.x_m), 1.0);
}

TEST(MotionModel, WithoutOdometryTheLastVelocityGoesOn) {
  MotionModel model;
  const Velocity2 velocity{0.8, 0.0, 0.5};
  model.update(at(1.0), {});
  model.update(at(1.2), velocity.after(0.2));
  const MotionGuess guess = model.guess(at(1.5));
  EXPECT_EQ(guess.source, MotionGuess::Source::velocity);
  // The chord's half-angle form is exact up to the ratio of chord to arc: turn^2/24.
  EXPECT_THAT(guess.before_from_now, IsNear(velocity.after(0.3), 2e-4, 1e-9));
  EXPECT_EQ(model.guess(at(9.0)).source, MotionGuess::Source::nothing);
  EXPECT_EQ(model.guess(at(0.9)).source, MotionGuess::Source::nothing);
}

TEST(MotionModel, StampsInBurstsDoNotMakeTheRobotFly) {
  MotionModel model;
  const Pose2 step{0.06, 0, 0};  // 0.3 m/s at 5 scans a second, logged two at a time
  for (int i = 0; i < 20; ++i) {
    model.update(at(0.4 * (i / 2) + 0.001 * (i % 2)), i == 0 ? Pose2{} : step);
  }
  EXPECT_GT(model.velocity().ahead_m_per_s, 0.1);
  EXPECT_LT(model.velocity().ahead_m_per_s, 0.5);
  MotionModel first;
  first.update(at(0.0), {});
  first.update(at(0.001), step);
  EXPECT_EQ(first.velocity().ahead_m_per_s, 0.0);
}

TEST(MotionModel, AGyroReplacesTheHeadingWhereItKnowsBetter) {
  MotionModel model;
  model.update(at(1.0, Pose2{}, 3.0), {});
  const MotionGuess guess = model.guess(at(1.1, Pose2{0.1, 0, 0.5}, 3.1));
  EXPECT_THAT(guess.before_from_now, IsNear(Pose2{0.1, 0, 0.1}, 1e-12, 1e-12));
}

}  // namespace
}  // namespace marco::slam
