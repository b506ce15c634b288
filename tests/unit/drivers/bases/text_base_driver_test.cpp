#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "simulator/devices/textbase/emulator.hpp"
#include "text_base.hpp"

namespace marco::drivers::textbase {
namespace {

using ::testing::HasSubstr;
using Fate = BaseStatus::Command;
using Link = BaseStatus::Link;

struct Parts {
  Parts(const TextBaseOptions& options, const TextBoardOptions& device)
      : board(device, [this] { return touch; }), driver(options) {}
  unsigned touch = 0;
  TextBoard board;
  TextBase driver;
};

struct Robot : Parts, testing::DrivenBase<TextBase> {
  explicit Robot(const TextBaseOptions& options = small_robot(),
                 const TextBoardOptions& device = {})
      : Parts(options, device), DrivenBase(driver, board, kBaud), options_(options) {}
  double moved_m() const {
    return (board.left_ticks() + board.right_ticks()) / 2.0 / ticks_per_m(options_);
  }
  double turned_rad() const {
    return (board.right_ticks() - board.left_ticks()) / ticks_per_m(options_) / options_.track_m;
  }
  TextBaseOptions options_;
};

TEST(TextBaseDriver, KnowsItsBoard) {
  Robot robot;
  EXPECT_EQ(robot.driver.status().note, "sim 1.0");
  EXPECT_TRUE(robot.driver.status().motors_on);
  robot.bench.run(1.2);
  EXPECT_EQ(robot.driver.status().battery_v, std::vector<double>{7.4});
  EXPECT_EQ(robot.driver.bad_input(), 0);
  EXPECT_NEAR(static_cast<double>(robot.odometry.size()), 50.0 * 1.5, 5.0);
}

TEST(TextBaseDriver, GeometryHasNoDefault) {
  EXPECT_THROW(TextBase(TextBaseOptions{}), std::invalid_argument);
}

// An Arduino's boot loader listens after the opening, and takes what it hears for a program.
TEST(TextBaseDriver, SaysNothingToABootLoader) {
  TextBase driver(small_robot());
  const Utime start = Utime::from_us(1'000'000'000);
  driver.on_connection(true, start);
  std::vector<uint8_t> out;
  driver.advance(start + Duration::from_seconds(1.9), out);
  EXPECT_TRUE(out.empty());
  driver.advance(start + Duration::from_seconds(2.1), out);
  EXPECT_EQ(std::string(out.begin(), out.end()), "V?*69\n");
}

TEST(TextBaseDriver, MovesTurnsAndReckons) {
  TextBoardOptions sluggish;
  sluggish.lag_s = 0.06;
  Robot robot(small_robot(), sluggish);
  EXPECT_EQ(robot.move(1.0), Fate::done);
  EXPECT_NEAR(robot.moved_m(), 1.0, 0.01);
  EXPECT_EQ(robot.turn(deg_to_rad(90.0)), Fate::done);
  EXPECT_NEAR(rad_to_deg(robot.turned_rad()), 90.0, 2.0);
  EXPECT_EQ(robot.move(-0.5), Fate::done);
  EXPECT_EQ(robot.turn(deg_to_rad(-200.0)), Fate::done);
  EXPECT_NEAR(rad_to_deg(robot.turned_rad()), -110.0, 4.0);
  const Pose2& pose = robot.driver.odom_from_robot();
  EXPECT_NEAR(pose.x_m, 1.0, 0.02);
  EXPECT_NEAR(pose.y_m, -0.5, 0.03);
  // A tick of 0.14 mm.
  EXPECT_NEAR(normalize_angle(pose.theta_rad - robot.turned_rad()), 0.0, 0.003);
}

TEST(TextBaseDriver, StampsAreWhenTheTicksWereCounted) {
  Robot robot;
  for (int i = 0; i < 5; ++i) {
    robot.velocity(0.2, 0.0);
    robot.bench.run(0.3);
  }
  robot.odometry.clear();
  std::vector<std::pair<Utime, double>> truth;
  for (int i = 0; i < 40; ++i) {
    robot.velocity(0.2, 0.0);
    robot.bench.run(0.01);
    truth.emplace_back(robot.bench.now(), robot.moved_m());
  }
  ASSERT_GT(robot.odometry.size(), 15U);
  for (const OdometrySample& sample : robot.odometry) {
    const auto [when, moved_m] = truth.back();
    const double expected_m = moved_m - 0.2 * (when - sample.utime).seconds();
    EXPECT_NEAR(sample.odom_from_robot.x_m, expected_m, 0.0015);  // 2 ms and a tick; 5 ms steps
    EXPECT_NEAR(sample.velocity_m_per_s, 0.2, 0.01);
  }
}

TEST(TextBaseDriver, AVelocityThatIsNotRepeatedEndsByItself) {
  Robot robot;
  robot.velocity(0.2, 0.5);
  robot.bench.run(0.45);
  EXPECT_GT(robot.board.right_ticks_per_s(), 300.0);
  EXPECT_GT(robot.board.right_ticks_per_s(), robot.board.left_ticks_per_s());
  // 0.5 s after the order comes the stop; then it brakes with 0.3 m/s2.
  EXPECT_TRUE(robot.bench.run_until(1.5, [&] {
    return robot.board.left_ticks_per_s() == 0.0 && robot.board.right_ticks_per_s() == 0.0;
  }));
  robot.bench.run(0.3);
  EXPECT_EQ(robot.driver.status().command, Fate::done);
}

TEST(TextBaseDriver, TheBoardStopsWhenItsHostDies) {
  for (const bool is_cut : {false, true}) {
    Robot robot;
    robot.begin_move(5.0);
    robot.bench.run(1.5);
    ASSERT_GT(robot.board.left_ticks_per_s(), 1000.0);
    if (is_cut) robot.bench.plug(false);
    robot.bench.frozen = !is_cut;
    const double since_m = robot.moved_m();
    robot.bench.run(1.5);  // watchdog of 0.5 s
    EXPECT_EQ(robot.board.left_ticks_per_s(), 0.0);
    EXPECT_LT(robot.moved_m() - since_m, 0.3 * (0.5 + 0.15));
  }
}

TEST(TextBaseDriver, AnEmergencyStopBrakesAtOnce) {
  Robot robot;
  robot.begin_move(5.0);
  robot.bench.run(1.5);
  const double since_m = robot.moved_m();
  EmergencyStop stop;
  stop.utime = robot.bench.now();
  robot.driver.emergency_stop(stop, robot.bench.now());
  robot.bench.run(0.6);
  EXPECT_EQ(robot.board.left_ticks_per_s(), 0.0);
  EXPECT_LT(robot.moved_m() - since_m, 0.3 * 0.1);  // the wheels' own 30 ms
  EXPECT_EQ(robot.driver.status().command, Fate::aborted);
  EXPECT_EQ(robot.move(0.1), Fate::refused);
}

TEST(TextBaseDriver, ABoardThatWasResetGoesOnFromWhereItWas) {
  Robot robot;
  EXPECT_EQ(robot.move(0.5), Fate::done);
  robot.board.reset(robot.bench.now());
  EXPECT_TRUE(robot.bench.run_until(3.0, [&] { return robot.driver.status().link != Link::up; }));
  EXPECT_TRUE(robot.comes_up(3.0));
  EXPECT_EQ(robot.move(0.5), Fate::done);
  EXPECT_NEAR(robot.driver.odom_from_robot().x_m, 1.0, 0.02);
  EXPECT_NEAR(robot.moved_m(), 1.0, 0.02);
}

TEST(TextBaseDriver, BumpersRedButtonAndFault) {
  Robot robot;
  robot.begin_move(3.0);
  robot.bench.run(1.0);
  robot.touch = kLeftBumper;
  EXPECT_TRUE(
      robot.bench.run_until(1.0, [&] { return robot.driver.status().command == Fate::shortened; }));
  EXPECT_EQ(robot.driver.status().bumpers, (std::vector<bool>{true, false}));
  EXPECT_EQ(robot.move(0.5), Fate::refused);
  EXPECT_THAT(robot.driver.status().note, HasSubstr("front bumper 1"));
  EXPECT_EQ(robot.move(-0.2), Fate::done);
  robot.touch = 0;
  robot.bench.run(0.2);
  for (const auto& [flag, said] : {std::pair{kEmergencyStop, "emergency stop is pressed"},
                                   std::pair{kFault, "reports a fault"}}) {
    robot.begin_move(3.0);
    robot.bench.run(0.5);
    robot.touch = flag;
    robot.bench.run(0.1);
    EXPECT_EQ(robot.driver.status().command, Fate::aborted);
    EXPECT_THAT(robot.driver.status().note, HasSubstr(said));
    EXPECT_EQ(robot.move(0.5), Fate::refused);
    robot.touch = 0;
    EXPECT_TRUE(robot.comes_up(0.2));
    robot.bench.run(1.0);
    EXPECT_EQ(robot.board.left_ticks_per_s(), 0.0) << "it took up its order again";
  }
}

TEST(TextBaseDriver, BlockedWheelsEndALeg) {
  TextBoardOptions stiff;
  stiff.most_ticks_per_s = 0;
  Robot robot(small_robot(), stiff);
  EXPECT_EQ(robot.move(0.5, 5.0), Fate::aborted);
  EXPECT_THAT(robot.driver.status().note, HasSubstr("the wheels do not turn"));
}

TEST(TextBaseDriver, SpoiltBytesCostNoWayAndNoLink) {
  Robot robot;
  std::mt19937 random(8);
  robot.bench.spoil = [&](std::vector<uint8_t>& bytes) {
    if (!bytes.empty() && random() % 30 == 0) {
      bytes[0] = static_cast<uint8_t>(bytes[0] ^ 1U << random() % 7);
    }
  };
  for (int i = 0; i < 8; ++i) EXPECT_EQ(robot.move(0.3), Fate::done);
  robot.bench.spoil = nullptr;
  robot.bench.run(0.3);
  EXPECT_GT(robot.driver.bad_input(), 5);
  EXPECT_NEAR(robot.driver.odom_from_robot().x_m, robot.moved_m(), 0.001);
}

/// A board's lines by hand.
class Lines : public ::testing::Test {
 protected:
  Lines() {
    driver_.on_connection(true, now_);
    say("V 1 mybot 0.3 wd=500");
    say("K W 500");
    say("K R 20");
  }
  void say(const std::string& line) {
    const std::string text = line + "\n";
    now_ = now_ + Duration::from_us(20'000);
    driver_.receive({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, now_);
    std::vector<uint8_t> out;
    driver_.advance(now_, out);
  }
  Utime now_ = Utime::from_us(1'000'000'000);
  TextBase driver_{small_robot()};
};

TEST_F(Lines, CountersAndClockWrap) {
  say("T 4294967286 2147483640 -2147483640 1");
  EXPECT_EQ(driver_.status().link, Link::up);
  say("T 10 -2147483644 -2147483628 1");
  EXPECT_EQ(driver_.status().link, Link::up);
  // 12 ticks each.
  EXPECT_NEAR(driver_.odom_from_robot().x_m, 12.0 / ticks_per_m(small_robot()), 1e-9);
}

TEST_F(Lines, AClockThatGoesBackIsAReset) {
  say("T 5000 100 100 1");
  say("T 20 0 0 0");
  EXPECT_THAT(driver_.status().note, HasSubstr("was reset"));
  EXPECT_EQ(driver_.odom_from_robot().x_m, 0.0);
}

TEST_F(Lines, ALeapOfTheCountersIsNoWay) {
  say("T 5000 100 100 1");
  say("T 5020 900000 900000 1");
  say("T 5040 900007 900007 1");
  EXPECT_NEAR(driver_.odom_from_robot().x_m, 7.0 / ticks_per_m(small_robot()), 1e-9);
  EXPECT_EQ(driver_.bad_input(), 1);
}

TEST_F(Lines, OnceThereAreSumsALineWithoutIsNone) {
  say(with_sum("T 5000 100 100 1"));
  say("T 5020 200 200 1");
  EXPECT_EQ(driver_.bad_input(), 1);
  say("V 1 mybot 0.3 wd=500");  // it was reset, and does not know of sums yet
  EXPECT_EQ(driver_.bad_input(), 1);
}

TEST_F(Lines, ABoardOfTheFutureIsRefused) {
  say("V 2 mybot 9 wd=500");
  say("T 5000 100 100 1");
  EXPECT_EQ(driver_.status().link, Link::starting);
  EXPECT_THAT(driver_.status().note, HasSubstr("speaks protocol 2"));
}

TEST_F(Lines, WhatTheBoardComplainsOfIsSaid) {
  say("T 5000 100 100 1");
  say("E 6 battery low");
  EXPECT_THAT(driver_.status().note, HasSubstr("battery low"));
  EXPECT_EQ(driver_.bad_input(), 0);
  say("E 2 checksum");
  EXPECT_EQ(driver_.bad_input(), 1);
}

}  // namespace
}  // namespace marco::drivers::textbase
