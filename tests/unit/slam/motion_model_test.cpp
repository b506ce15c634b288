#include "slam/front_end/motion_model.hpp"

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

TEST(MotionModel, WhatSwingsFromScanToScanDoesNotStraightenScans) {
  MotionModel model;
  for (int i = 0; i < 11; ++i) model.update(at(0.15 * i), {0.0, 0.0, i % 2 == 0 ? 0.3 : -0.3});
  EXPECT_NEAR(model.velocity().yaw_rad_per_s, 0.0, 1e-9);
  EXPECT_NEAR(model.guess(at(1.65)).before_from_now.theta_rad, 0.3, 1e-9);
}

TEST(MotionModel, AVelocityNoRobotHasIsNotBelieved) {
  const MotionOptions options;
  EXPECT_THAT(believed_velocity({0.2, 0, 0.3}, 0.2, options)->after(0.2),
              IsNear(Pose2{0.2, 0, 0.3}, 1e-3, 1e-12));
  EXPECT_FALSE(believed_velocity({5.0, 0, 0}, 0.2, options)) << "odometry started anew";
  EXPECT_FALSE(believed_velocity({0, 0, 2.0}, 0.2, options));
  EXPECT_FALSE(believed_velocity({}, 0.0, options)) << "no time, no velocity";
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

// 0.5 m/s at 5 scans a second; every fourth to sixth scan is logged with the third one's stamp, and
// odometry looked up by it.
TEST(MotionModel, OdometryOfAnotherMomentIsMadeUpForWhenTheStampsCatchUp) {
  MotionModel model;
  const Pose2 step{0.1, 0, 0.02};
  Pose2 truth, stamped;
  for (int i = 0; i < 60; ++i) {
    const bool stale = i % 6 > 2;
    if (i > 0) truth = truth * step;
    if (!stale) stamped = truth;
    const double stamp_s = 0.2 * (stale ? i - i % 6 + 2 : i) + 0.001 * (stale ? i % 6 - 2 : 0);
    const MotionInput now = at(stamp_s, stamped);
    if (i > 12) {
      EXPECT_THAT(model.guess(now).before_from_now, IsNear(step, 0.002, 0.002)) << i;
    }
    model.update(now, i == 0 ? Pose2{} : step);
  }
}

TEST(MotionModel, OdometryThatCameWithTheScanDoesNotMindItsStamp) {
  MotionModel model;
  Pose2 truth;
  for (int i = 0; i < 60; ++i) {
    const Pose2 step{0.05 + 0.05 * (i / 7 % 2), 0, 0.1 * (i / 5 % 2)};  // changes as it likes
    truth = truth * step;
    const double stamp_s = 0.2 * (i - i % 3) + 0.001 * (i % 3);
    const MotionInput now = at(stamp_s, truth);
    if (i > 12) {
      EXPECT_THAT(model.guess(now).before_from_now, IsNear(step, 1e-9, 1e-9)) << i;
    }
    model.update(now, step);
  }
}

TEST(MotionModel, ARobotStandsWhenOdometryAndTheScansSaySo) {
  MotionModel model;
  EXPECT_FALSE(model.stands_still(at(1.0, Pose2{})));
  model.update(at(1.0, Pose2{}), {});
  EXPECT_TRUE(model.stands_still(at(1.2, Pose2{})));
  EXPECT_FALSE(model.stands_still(at(1.2, Pose2{0.01, 0, 0})));
  EXPECT_FALSE(model.stands_still(at(1.2)));
  model.update(at(1.2, Pose2{}), {0.1, 0, 0});  // pushed
  EXPECT_FALSE(model.stands_still(at(1.4, Pose2{})));
}

}  // namespace
}  // namespace marco::slam
