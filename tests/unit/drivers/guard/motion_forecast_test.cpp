// Where a base goes, and what its wheels count.
#include "drivers/base/motion_forecast.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/base/speed_profile.hpp"
#include "drivers/base/wheel_counters.hpp"

namespace marco::drivers {
namespace {

Utime in(double seconds) { return Utime::from_seconds(1000.0 + seconds); }

/// A base that obeys after 0.3 s, by 0.3 m/s2 and 1 rad/s2.
class Forecast : public ::testing::Test {
 protected:
  Forecast() { forecast_.set_dynamics({0.3, 0.3, 1.0, 1.0}); }
  Pose2 end_of(const BaseVelocity& order, double now_s) const {
    return forecast_.stopping_way(order, 0.1, in(now_s), 0.4).back().start_from_robot;
  }
  MotionForecast forecast_{0.3};
};

TEST_F(Forecast, ARestingBaseStaysAndOneWithAnOrderGoesForItsTime) {
  EXPECT_EQ(forecast_.stopping_way({}, 0.1, in(0.0), 0.4).size(), 1U);
  // 0.1 s of acceleration, and as much of braking.
  EXPECT_NEAR(end_of({0.4, 0.0}, 0.0).x_m, 0.003, 0.001);
  EXPECT_NEAR(end_of({0.0, -1.0}, 0.0).theta_rad, -0.01, 0.003);
}

TEST_F(Forecast, WhatMovesGoesOnForTheDelayAndBrakesThen) {
  forecast_.on_sent({0.4, 0.5}, in(0.0));
  forecast_.on_measured({0.4, 0.5}, 1.0, in(2.0));
  const Pose2 end = end_of({}, 2.0);
  // The delay, and then v2 / 2a.
  EXPECT_NEAR(end.theta_rad, 0.5 * 0.3 + 0.125, 0.02);
  const double way_m = 0.4 * 0.3 + 0.4 * 0.4 / 0.6;
  EXPECT_NEAR(std::hypot(end.x_m, end.y_m), way_m, 0.02);
  EXPECT_GT(end.y_m, 0.03);
  const Sweep way = forecast_.stopping_way({}, 0.1, in(2.0), 0.4);
  for (std::size_t i = 1; i < way.size(); ++i) {
    EXPECT_LT(way[i].swept_m - way[i - 1].swept_m, 0.0115) << "steps of a centimetre at most";
  }
}

TEST_F(Forecast, WhatWasSentTakesEffectAfterTheDelay) {
  forecast_.on_sent({0.4, 0.0}, in(0.0));
  // A tenth of a second later it acts for another tenth before a stop that is sent now does.
  EXPECT_NEAR(end_of({}, 0.1).x_m, 0.003, 0.001);
  forecast_.on_measured({0.21, 0.0}, 1.0, in(1.0));
  // To 0.3 m/s in the delay; and then braking from there.
  EXPECT_NEAR(end_of({}, 1.0).x_m, 0.255 * 0.3 + 0.15, 0.015);
  forecast_.on_sent({}, in(1.0));
  forecast_.on_measured({}, 1.0, in(2.0));
  EXPECT_NEAR(end_of({}, 2.0).x_m, 0.0, 1e-9);
  forecast_.on_sent({0.4, 0.0}, in(3.0));
  forecast_.on_rest();
  EXPECT_NEAR(end_of({}, 3.1).x_m, 0.0, 1e-9);
}

TEST_F(Forecast, OfManyOrdersEachTakesEffectInItsTurn) {
  for (int i = 0; i < 20; ++i) forecast_.on_sent({i % 2 == 0 ? 0.4 : 0.3, 0.0}, in(0.1 * i));
  forecast_.on_measured({0.4, 0.0}, 1.0, in(2.0));
  const double way_m = end_of({}, 2.0).x_m;
  EXPECT_GT(way_m, 0.3 * 0.3 + 0.15);
  EXPECT_LT(way_m, 0.4 * 0.3 + 0.27);
}

// Of a few ticks: coarse.
TEST_F(Forecast, AVelocityMeasuredOverFiftyMillisecondsCountsWholeAndOverLessInPart) {
  forecast_.on_sent({0.4, 0.2}, in(0.0));
  forecast_.on_measured({0.4, 0.2}, 1.0, in(1.0));
  forecast_.on_measured({0.5, 0.6}, 0.025, in(1.025));
  EXPECT_NEAR(forecast_.measured().ahead_m_per_s, 0.45, 1e-9);
  EXPECT_NEAR(forecast_.measured().turn_rad_per_s, 0.4, 1e-9);
  forecast_.on_measured({0.1, 0.0}, 0.06, in(1.085));
  EXPECT_NEAR(forecast_.measured().ahead_m_per_s, 0.1, 1e-9);
  EXPECT_NEAR(forecast_.measured().turn_rad_per_s, 0.0, 1e-9);
}

TEST_F(Forecast, NoWayIsLongerThanSixMetres) {
  forecast_.set_dynamics({0.3, 0.01, 1.0, 1.0});
  forecast_.on_measured({3.0, 0.0}, 1.0, in(1.0));
  EXPECT_NEAR(end_of({3.0, 0.0}, 1.0).x_m, 6.0, 0.4);
}

TEST(SpeedProfile, AcceleratesAndBrakesByItsOwnRates) {
  const auto next = [](double speed, double goal) {
    SpeedProfile profile{1.0, 0.3, 0.6, speed, goal};
    profile.step(std::nullopt, 0.1);
    return profile.speed;
  };
  EXPECT_NEAR(next(0.2, 0.8), 0.23, 1e-12);
  EXPECT_NEAR(next(0.5, 0.1), 0.44, 1e-12);
  EXPECT_NEAR(next(-0.5, -0.1), -0.44, 1e-12);
  EXPECT_NEAR(next(0.2, -0.8), 0.14, 1e-12) << "turning round, it brakes first";
  EXPECT_NEAR(next(0.2, 0.21), 0.21, 1e-12);
  EXPECT_NEAR(next(0.99, 5.0), 1.0, 1e-12) << "its limit";
  EXPECT_NEAR(next(-0.99, -5.0), -1.0, 1e-12);
}

TEST(SpeedProfile, ArrivesAtAGoalWithoutPassingIt) {
  for (const double goal_m : {0.5, -0.5, 3.0}) {
    SpeedProfile profile{1.0, 0.3, 0.6};
    double left_m = goal_m, fastest = 0.0;
    for (int i = 0; i < 2000; ++i) {
      profile.step(left_m, 0.01);
      left_m -= 0.01 * profile.speed;
      fastest = std::max(fastest, std::abs(profile.speed));
      EXPECT_GT(left_m * goal_m, -0.03) << i;  // by the last steps of 10 ms
    }
    EXPECT_NEAR(left_m, 0.0, 0.005);
    // v2/2a up and down make the way, or the limit is reached.
    EXPECT_NEAR(fastest, std::min(1.0, std::sqrt(2.0 * std::abs(goal_m) * 0.2)), 0.03) << goal_m;
  }
}

TEST(SpeedProfile, ANegativeAccelerationIsThatOfBraking) {
  SpeedProfile profile{1.0, 0.3, 0.6};
  profile.set_acceleration(-0.2);
  profile.set_acceleration(0.0);
  EXPECT_EQ(profile.acceleration, 0.3);
  EXPECT_EQ(profile.deceleration, 0.2);
  profile.set_acceleration(0.7);
  EXPECT_EQ(profile.acceleration, 0.7);
  EXPECT_EQ(profile.deceleration, 0.2);
}

// A tick of a millimetre.
TEST(WheelCounters, CountOverTheirWrap) {
  WheelCounters wheels(0.001);
  const auto first = wheels.count(65500, 10, 0.1);
  EXPECT_EQ(first.left_clicks, 0.0);
  EXPECT_EQ(first.right_clicks, 0.0);
  const auto step = wheels.count(64, 65496, 0.2);
  EXPECT_EQ(step.left_clicks, 100.0);
  EXPECT_EQ(step.right_clicks, -50.0);
  EXPECT_NEAR(step.left_m_per_s, 0.5, 1e-12);
  EXPECT_NEAR(step.right_m_per_s, -0.25, 1e-12);
  EXPECT_EQ(wheels.count(164, 65496, 0.2).left_clicks, 100.0);
  wheels.forget();
  EXPECT_EQ(wheels.count(0, 0, 0.2).left_clicks, 0.0);
  EXPECT_EQ(wheels.implausible(), 0);
}

// 200 in 0.1 s, and ten that may come with another frame.
TEST(WheelCounters, FasterThanTwoMetresASecondIsAReset) {
  for (const int sign : {1, -1}) {
    WheelCounters wheels(0.001);
    const auto ticks = [&](int left, int right) {
      wheels.forget();
      wheels.count(30000, 30000, 0.1);
      return wheels.count(static_cast<uint16_t>(30000 + sign * left),
                          static_cast<uint16_t>(30000 + sign * right), 0.1);
    };
    EXPECT_EQ(ticks(205, 205).left_clicks, sign * 205.0);
    EXPECT_EQ(wheels.implausible(), 0);
    EXPECT_EQ(ticks(215, 0).left_clicks, 0.0);
    EXPECT_EQ(ticks(0, 215).right_clicks, 0.0);
    EXPECT_EQ(wheels.implausible(), 2);
  }
}

TEST(ClickOdometry, ReckonsAlongArcsAndSumsItsClicks) {
  ClickOdometry odometry(0.001, 0.4);
  const ClickOdometry::Step step{100.0, 300.0, 0.5, 1.5};
  const OdometrySample expected = odometry.predict(step, in(0.1));
  const OdometrySample sample = odometry.count(step, in(0.2));
  EXPECT_NEAR(sample.odom_from_robot.theta_rad, 0.5, 1e-12);
  EXPECT_NEAR(sample.odom_from_robot.x_m, 0.2 * std::cos(0.25), 1e-12);
  EXPECT_NEAR(sample.odom_from_robot.y_m, 0.2 * std::sin(0.25), 1e-12);
  EXPECT_NEAR(expected.odom_from_robot.y_m, sample.odom_from_robot.y_m, 1e-12);
  EXPECT_NEAR(sample.velocity_m_per_s, 1.0, 1e-12);
  EXPECT_NEAR(sample.yaw_rate_rad_per_s, 2.5, 1e-12);
  const OdometrySample next = odometry.count({-10.0, 20.0, 0.0, 0.0}, in(0.3));
  EXPECT_EQ(next.left_clicks, 90);
  EXPECT_EQ(next.right_clicks, 320);
  EXPECT_NEAR(next.odom_from_robot.theta_rad, 0.575, 1e-12);
}

TEST(ClickOdometry, ItsStampsAscendUntilTheyAreForgotten) {
  ClickOdometry odometry(0.001, 0.4);
  EXPECT_EQ(odometry.count({}, in(1.0)).utime, in(1.0));
  EXPECT_EQ(odometry.count({}, in(0.5)).utime, in(1.0) + Duration::from_us(1));
  EXPECT_EQ(odometry.count({}, in(1.0)).utime, in(1.0) + Duration::from_us(2));
  odometry.forget_stamps();
  EXPECT_EQ(odometry.count({}, in(0.5)).utime, in(0.5));
}

}  // namespace
}  // namespace marco::drivers
