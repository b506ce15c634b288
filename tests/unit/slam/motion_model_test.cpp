#include "slam/front_end/motion_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

// Of a match to a millimetre and a milliradian.
const Eigen::Matrix3d kSharp = 1e6 * Eigen::Matrix3d::Identity();

MotionInput at(double seconds, std::optional<Pose2> odom = {}, std::optional<double> gyro = {}) {
  return {Utime::from_seconds(seconds), odom, gyro, 0.15};
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
  EXPECT_LT(still.covariance()(0, 0), guess.covariance()(0, 0));
  EXPECT_LT(still.covariance()(2, 2), guess.covariance()(2, 2));
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
  EXPECT_NEAR(model.velocity_during({}, 0.0).velocity.yaw_rad_per_s, 0.0, 1e-9);
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

TEST(MotionModel, TwoScansOfNearlyOneStampTellNoVelocity) {
  MotionModel model;
  model.update(at(0.0), {});
  model.update(at(0.001), {0.06, 0, 0});
  EXPECT_EQ(model.velocity_during({}, 0.0).velocity.ahead_m_per_s, 0.0);
}

TEST(MotionModel, OdometryAboveTheLimitsIsNotTrustedMoreThanTheLastVelocity) {
  MotionModel model;
  model.update(at(0.0, Pose2{}), {});
  model.update(at(0.2, Pose2{0.1, 0, 0}), {0.1, 0, 0});
  const double usual_m2 = model.guess(at(0.4, Pose2{0.2, 0, 0})).covariance()(0, 0);
  const double leap_m2 = model.guess(at(0.4, Pose2{1.6, 0, 0})).covariance()(0, 0);
  EXPECT_LT(usual_m2, 0.001);
  EXPECT_GT(leap_m2, 1.4 * 1.4);
}

TEST(MotionModel, AnUnusualStepByAStampOffTheBeatIsTrustedLess) {
  MotionModel model;
  Pose2 odom;
  for (int i = 0; i < 20; ++i) {
    odom = odom * Pose2{0.2, 0, 0};
    model.update(at(0.2 * i, odom), {0.2, 0, 0});
  }
  const auto variance_m2 = [&](double step_m, double off_beat) {
    MotionInput now = at(4.0, odom * Pose2{step_m, 0, 0});
    now.off_beat = off_beat;
    return model.guess(now).covariance()(0, 0);
  };
  EXPECT_NEAR(variance_m2(0.2, 1.0), variance_m2(0.2, 0.0), 1e-6);
  EXPECT_GT(variance_m2(0.02, 0.9), variance_m2(0.02, 0.0) + 0.15 * 0.15);
}

TEST(MotionModel, AMoveBeyondTheLimitsExceedsThem) {
  MotionModel model;
  EXPECT_FALSE(model.exceeds_motion_limits({100, 0, 0}, Utime::from_seconds(0.0)));
  model.update(at(1.0, Pose2{}), {});
  const Utime later = Utime::from_seconds(1.1);
  EXPECT_FALSE(model.exceeds_motion_limits({0.55, 0, 0}, later));
  EXPECT_TRUE(model.exceeds_motion_limits({0.65, 0, 0}, later));
  EXPECT_FALSE(model.exceeds_motion_limits({0, 0, deg_to_rad(65)}, later));
  EXPECT_TRUE(model.exceeds_motion_limits({0, 0, deg_to_rad(75)}, later));
}

TEST(MotionModel, AGyroReplacesTheHeadingWhereItKnowsBetter) {
  MotionModel model;
  model.update(at(1.0, Pose2{}, 3.0), {});
  const MotionGuess guess = model.guess(at(1.1, Pose2{0.1, 0, 0.5}, 3.1));
  EXPECT_THAT(guess.before_from_now, IsNear(Pose2{0.1, 0, 0.1}, 1e-12, 1e-12));
}

TEST(MotionModel, ARobotStandsWhenOdometryAndTheScansSaySo) {
  MotionModel model;
  EXPECT_FALSE(model.stands_still(at(1.0, Pose2{}), kSharp));
  model.update(at(1.0, Pose2{}), {});
  EXPECT_TRUE(model.stands_still(at(1.2, Pose2{}), kSharp));
  EXPECT_FALSE(model.stands_still(at(1.2, Pose2{0.01, 0, 0}), kSharp));
  EXPECT_FALSE(model.stands_still(at(1.2), kSharp));
  model.update(at(1.2, Pose2{}), {0.1, 0, 0});  // pushed
  EXPECT_FALSE(model.stands_still(at(1.4, Pose2{}), kSharp));
}

TEST(MotionModel, ARobotStandsWhoseMatchesDifferByTheirNoise) {
  const Eigen::Matrix3d blurred = Eigen::Vector3d(1e5, 1e5, 1e6).asDiagonal();  // 3.2 mm
  const auto stands = [&](double move_m, const Eigen::Matrix3d& information) {
    MotionModel model;
    for (int i = 0; i < 30; ++i) {
      model.update(at(0.2 * i, Pose2{}), {i % 2 == 0 ? move_m : -move_m, 0, 0});
    }
    return model.stands_still(at(6.0, Pose2{}), information);
  };
  EXPECT_TRUE(stands(0.007, blurred));
  EXPECT_FALSE(stands(0.007, kSharp));
  EXPECT_FALSE(stands(0.012, blurred));
}

// A robot that drives and turns at changing speeds, seen by scans ten times a second; `sensor` says
// what odometry and gyro make of a true step.
template <class Sensor>
MotionModel driven(const Sensor& sensor, int scans = 100) {
  MotionModel model;
  Pose2 odom;
  double gyro_rad = 0.0;
  for (int i = 0; i < scans; ++i) {
    const double speed = 0.5 + 0.4 * std::sin(0.3 * i);
    const Pose2 step{0.1 * speed, 0.0, i % 30 < 10 ? 0.1 * speed : 0.0};
    const auto [measured, turned_rad] = sensor(step);
    odom = odom * measured;
    gyro_rad += turned_rad;
    model.update(at(0.1 * i, odom, gyro_rad), i == 0 ? Pose2{} : step);
  }
  return model;
}

TEST(MotionModel, OdometryThatExplainsTheMotionIsTrustedThoughItErrs) {
  const auto of = [](double scale, double drift_rad) {
    return driven([=](const Pose2& step) {
      const Pose2 measured{scale * step.x_m, 0, step.theta_rad + drift_rad};
      return std::pair(measured, step.theta_rad);
    });
  };
  EXPECT_TRUE(of(1.0, 0.0).trusts_odometry());
  EXPECT_TRUE(of(0.6, 0.001).trusts_odometry());
  EXPECT_TRUE(of(1.4, -0.001).trusts_odometry());
}

TEST(MotionModel, OdometryThatExplainsNothingIsAsGoodAsNone) {
  const auto of = [](double forward, double turn) {
    return driven([=](const Pose2& step) {
      const Pose2 measured{forward * step.x_m, 0, turn * step.theta_rad};
      return std::pair(measured, step.theta_rad);
    });
  };
  for (const MotionModel& model : {of(0.0, 0.0), of(-1.0, 1.0), of(1.0, -1.0)}) {
    EXPECT_FALSE(model.trusts_odometry());
    const MotionState state = model.state();
    if (state.explained_by_odometry.explains_translation()) continue;  // only turns are wrong
    MotionInput now = *model.state().before;
    now.utime = now.utime + Duration::from_seconds(0.1);
    EXPECT_EQ(model.guess(now).source, MotionGuess::Source::velocity);
    EXPECT_GT(model.guess(now).before_from_now.x_m, 0.005) << "it drives on";
    EXPECT_FALSE(model.stands_still(now, kSharp)) << "constant odometry is no sign of standing";
  }
}

TEST(MotionModel, AGyroOfTheWrongSignOrUnitIsLeftOut) {
  for (const double scale : {-1.0, 57.3, 0.0175}) {
    const MotionModel model =
        driven([=](const Pose2& step) { return std::pair(step, scale * step.theta_rad); });
    MotionInput now = *model.state().before;
    now.utime = now.utime + Duration::from_seconds(0.1);
    *now.gyro_heading_rad += 0.5;
    EXPECT_EQ(model.guess(now).before_from_now.theta_rad, 0.0) << scale;
  }
}

TEST(MotionModel, MatchesThatDoNotKnowTheWayDoNotJudgeIt) {
  MotionModel model;
  for (int i = 0; i < 60; ++i) {
    model.update(at(0.1 * i, Pose2{0.05 * i, 0, 0}), {i == 0 ? 0.0 : 0.01, 0, 0}, true,
                 0.04 * Eigen::Matrix3d::Identity());
  }
  EXPECT_TRUE(model.trusts_odometry());
  EXPECT_EQ(model.state().odometry_error.m2, 0.0);
}

// As of a base that is not connected, along a bare wall.
TEST(MotionModel, OdometryThatHasNeverMovedPredictsNothing) {
  MotionModel model;
  for (int i = 0; i < 5; ++i) model.update(at(0.2 * i, Pose2{3, 4, 0}), {i == 0 ? 0.0 : 0.1, 0, 0});
  const MotionGuess still = model.guess(at(1.0, Pose2{3, 4, 0}));
  EXPECT_EQ(still.source, MotionGuess::Source::velocity);
  EXPECT_THAT(still.before_from_now, IsNear(Pose2{0.1, 0, 0}, 0.01, 0.01));
  EXPECT_EQ(model.guess(at(1.0, Pose2{3, 4, 0}), false).source, MotionGuess::Source::odometry)
      << "no match will judge a tilted scan";
  EXPECT_EQ(model.guess(at(9.0, Pose2{3, 4, 0})).source, MotionGuess::Source::odometry)
      << "after a gap nothing else is known";
  const Eigen::Matrix3d along_unknown = Eigen::Vector3d(1e-6, 1e6, 1e6).asDiagonal();
  EXPECT_FALSE(model.stands_still(at(1.0, Pose2{3, 4, 0}), along_unknown));
  model.update(at(1.0, Pose2{3.1, 4, 0}), {0.1, 0, 0});
  EXPECT_EQ(model.guess(at(1.2, Pose2{3.1, 4, 0})).source, MotionGuess::Source::odometry);
}

// Along a bare corridor matches stay behind, by as much as they do not know.
TEST(MotionModel, MatchesThatDoNotKnowTheWayDoNotStopTheRobot) {
  MotionModel model;
  double now_s = 0.0;
  const auto drive = [&](int scans, double found_m, const Eigen::Matrix3d& covariance) {
    for (int i = 0; i < scans; ++i) {
      model.update(at(now_s), {found_m, 0.02, 0}, true, covariance);
      now_s += 0.2;
    }
    return model.guess(at(now_s)).before_from_now;
  };
  drive(30, 0.10, Eigen::Vector3d(1e-6, 1e-6, 1e-6).asDiagonal());
  const Pose2 in_corridor = drive(5, 0.02, Eigen::Vector3d(0.04, 1e-6, 1e-6).asDiagonal());
  EXPECT_THAT(in_corridor, IsNear(Pose2{0.10, 0.02, 0}, 0.01, 1e-6));
  const Pose2 in_room = drive(5, 0.02, Eigen::Vector3d(1e-6, 1e-6, 1e-6).asDiagonal());
  EXPECT_THAT(in_room, IsNear(Pose2{0.02, 0.02, 0}, 0.01, 1e-6));
}

}  // namespace
}  // namespace marco::slam
