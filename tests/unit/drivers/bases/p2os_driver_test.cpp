#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "driven_base.hpp"
#include "drivers/p2os/driver.hpp"
#include "simulator/devices/p2os/emulator.hpp"

namespace marco::drivers::p2os {
namespace {

using Fate = BaseStatus::Command;
using Link = BaseStatus::Link;

struct Parts {
  Parts(const P2osOptions& options, P2osWorld world, const P2osEmulatorOptions& device)
      : robot(std::move(world), device), driver(options) {}
  P2osEmulator robot;
  P2osBase driver;
};

struct Pioneer : Parts, testing::DrivenBase<P2osBase> {
  explicit Pioneer(const P2osOptions& options = {},
                   P2osWorld world = {},
                   const P2osEmulatorOptions& device = {})
      : Parts(options, std::move(world), device), DrivenBase(driver, robot, kBaud) {}
};

// Its speed is a parameter in its flash.
TEST(P2osDriver, FindsTheRobotAtEachSpeed) {
  for (int code = 0; code < 5; ++code) {
    P2osEmulatorOptions device;
    device.host_baud = code;
    P2osEmulator robot({}, device);
    P2osBase driver({});
    testing::Bench<P2osBase> bench(driver, robot, kBaud);
    const Utime begin = bench.now();
    const auto up = [&] { return driver.status().link == BaseStatus::Link::up; };
    EXPECT_TRUE(bench.run_until(9.0, up)) << code << ": " << driver.state();
    std::printf("P2OS: speed %d found after %.1f s\n", code, (bench.now() - begin).seconds());
    bench.run(2.0);
    EXPECT_TRUE(up());
    EXPECT_EQ(driver.bad_input(), 0);
    // The line was cut: the speed is known now.
    bench.plug(false);
    bench.run(3.0);
    bench.plug(true);
    EXPECT_TRUE(bench.run_until(2.5, up)) << code;
  }
}

// Another robot's units would put it elsewhere without a word.
TEST(P2osDriver, AnUnknownRobotIsSaidAndTakenWithItsUnitsOnly) {
  P2osEmulatorOptions device;
  device.name.subtype = "p9xx";
  P2osEmulator robot({}, device);
  P2osBase driver({});
  testing::Bench<P2osBase> bench(driver, robot, kBaud);
  bench.run(12.0);
  EXPECT_EQ(driver.status().link, Link::down);
  EXPECT_THAT(driver.status().note,
              ::testing::HasSubstr("'p9xx' is not known: set mm_per_distance"));
  EXPECT_EQ(driver.odom_from_robot().x_m, 0.0);

  P2osOptions options;
  options.mm_per_distance = 0.84;
  EXPECT_THROW(P2osBase{options}, std::invalid_argument) << "all or none";
  options.mm_per_range = 0.268;
  options.rad_per_mm_per_s = 0.0056;
  P2osEmulator same({}, device);
  P2osBase told(options);
  testing::Bench<P2osBase> other(told, same, kBaud);
  EXPECT_TRUE(other.run_until(9.0, [&] { return told.status().link == Link::up; }));
}

TEST(P2osDriver, ShakesHandsAndReadsTheRobot) {
  P2osWorld world;
  world.sonar_range_m = [](const Pose2& sonar) {
    const bool fourth = sonar.x_m == 0.166 && sonar.y_m > 0.0;
    return fourth ? HUGE_VAL : 1.0 - 0.5 * sonar.y_m;
  };
  Pioneer pioneer({}, world);
  EXPECT_EQ(pioneer.driver.name().subtype, "P2DX");
  EXPECT_TRUE(pioneer.robot.motors_on());
  EXPECT_EQ(pioneer.driver.status().battery_v, std::vector<double>{12.6});
  pioneer.bench.run(1.0);
  ASSERT_FALSE(pioneer.rings.empty());
  EXPECT_NEAR(pioneer.rings.back().readings[5].range_m, 1.039, 0.001);
  EXPECT_EQ(pioneer.rings.back().readings[3].range_m, 0.0);
  EXPECT_EQ(pioneer.driver.status().bumpers.size(), 10U);
  EXPECT_EQ(pioneer.driver.bad_input(), 0);
}

// Their units and sonars differ: each is driven in its own.
TEST(P2osDriver, DrivesWhatOtherRobotsItKnows) {
  struct Known {
    const char* subtype;
    std::size_t sonars;
    Pose2 last;
  };
  const Known robots[] = {{"p3dx", 16, {-0.157, 0.136, deg_to_rad(90)}},
                          {"P3AT-SH-lms500", 16, {-0.144, 0.136, deg_to_rad(90)}},
                          {"amigo", 8, {-0.140, 0.058, deg_to_rad(145)}},
                          {"p2pp", 24, {-0.157, 0.136, deg_to_rad(90)}},
                          {"peoplebot-sh", 32, {-0.191, 0.136, deg_to_rad(90)}},
                          {"powerbot", 28, {-0.298, 0.278, deg_to_rad(90)}}};
  for (const auto& [subtype, sonars, last] : robots) {
    P2osEmulatorOptions device;
    device.name.subtype = subtype;
    P2osWorld world;
    world.sonar_range_m = [](const Pose2& sonar) { return 1.0 + sonar.x_m; };
    Pioneer pioneer({}, world, device);
    EXPECT_EQ(pioneer.move(0.8), Fate::done) << subtype;
    EXPECT_EQ(pioneer.turn(deg_to_rad(60.0)), Fate::done) << subtype;
    EXPECT_NEAR(pioneer.driver.odom_from_robot().x_m, pioneer.robot.reckoned().x_m, 0.004)
        << subtype;
    double fastest = 0.0;
    pioneer.bench.run(1.0);
    for (const OdometrySample& sample : pioneer.odometry) {
      fastest = std::max(fastest, sample.velocity_m_per_s);
    }
    EXPECT_NEAR(fastest, 0.3, 0.01) << subtype;
    ASSERT_FALSE(pioneer.rings.empty()) << subtype;
    const SonarRing& ring = pioneer.rings.back();
    ASSERT_EQ(ring.readings.size(), sonars) << subtype;
    const Pose2 off = last.inverse() * ring.readings.back().robot_from_sonar;
    EXPECT_NEAR(off.vector().norm(), 0.0, 1e-9) << subtype;
    for (const auto& reading : ring.readings) {
      EXPECT_NEAR(reading.range_m, 1.0 + reading.robot_from_sonar.x_m, 0.001) << subtype;
    }
  }
}

TEST(P2osDriver, MovesTurnsAndReckons) {
  Pioneer pioneer;
  EXPECT_EQ(pioneer.move(1.0), Fate::done);
  EXPECT_EQ(pioneer.turn(deg_to_rad(90.0)), Fate::done);
  EXPECT_EQ(pioneer.move(-0.5), Fate::done);
  EXPECT_EQ(pioneer.turn(deg_to_rad(-200.0)), Fate::done);
  const Pose2& truth = pioneer.robot.reckoned();
  const Pose2& pose = pioneer.driver.odom_from_robot();
  // A unit of 0.84 mm lost at each packet's rounding does not add up: differences telescope.
  EXPECT_NEAR(pose.x_m, truth.x_m, 0.003);
  EXPECT_NEAR(pose.y_m, truth.y_m, 0.003);
  EXPECT_NEAR(normalize_angle(pose.theta_rad - truth.theta_rad), 0.0, 0.003);
  EXPECT_NEAR(truth.x_m, 1.0, 0.02);
  EXPECT_NEAR(truth.y_m, -0.5, 0.02);
  EXPECT_NEAR(rad_to_deg(truth.theta_rad), -110.0, 1.5);
}

TEST(P2osDriver, ReckonsAcrossTheWrapOfItsCounters) {
  Pioneer pioneer;
  // 15 bits of 0.84 mm are 27.5 m.
  for (int i = 0; i < 3; ++i) EXPECT_EQ(pioneer.move(10.0), Fate::done);
  EXPECT_NEAR(pioneer.driver.odom_from_robot().x_m, 30.0, 0.06);
}

TEST(P2osDriver, AVelocityThatIsNotRepeatedEndsByItself) {
  Pioneer pioneer;
  pioneer.velocity(0.2, 0.3);
  pioneer.bench.run(0.45);
  EXPECT_GT(pioneer.robot.velocity_m_per_s(), 0.1);
  // 0.5 s after the order comes the stop; then it brakes with 0.3 m/s2.
  EXPECT_TRUE(pioneer.bench.run_until(1.0, [&] {
    return pioneer.robot.velocity_m_per_s() == 0.0 && pioneer.robot.yaw_rate_rad_per_s() == 0.0;
  }));
  pioneer.bench.run(0.5);
  EXPECT_EQ(pioneer.driver.status().command, Fate::done);
}

TEST(P2osDriver, TheRobotStopsItselfWhenTheLineIsCut) {
  Pioneer pioneer;
  pioneer.begin_move(20.0);
  pioneer.bench.run(2.0);
  ASSERT_GT(pioneer.robot.velocity_m_per_s(), 0.2);
  pioneer.bench.plug(false);
  pioneer.bench.run(0.1);
  EXPECT_EQ(pioneer.driver.status().command, Fate::aborted);
  pioneer.bench.run(4.0);  // watchdog of 2 s, and the braking
  EXPECT_EQ(pioneer.robot.velocity_m_per_s(), 0.0);
  pioneer.bench.plug(true);
  EXPECT_TRUE(pioneer.comes_up(3.0));
  pioneer.bench.run(0.3);
  EXPECT_EQ(pioneer.move(0.2), Fate::done);
}

TEST(P2osDriver, AResetRobotIsOpenedAgain) {
  Pioneer pioneer;
  EXPECT_EQ(pioneer.move(0.5), Fate::done);
  pioneer.robot.reset();
  EXPECT_TRUE(
      pioneer.bench.run_until(3.0, [&] { return pioneer.driver.status().link != Link::up; }));
  EXPECT_TRUE(pioneer.comes_up(3.0));
  pioneer.bench.run(0.3);
  EXPECT_EQ(pioneer.move(0.5), Fate::done);
  EXPECT_NEAR(pioneer.driver.odom_from_robot().x_m, 1.0, 0.02);  // its own path goes on
}

TEST(P2osDriver, BumpersAndStallEndAMove) {
  Touch touch;
  P2osWorld world;
  world.touch = [&touch] { return touch; };
  Pioneer pioneer({}, world);
  pioneer.begin_move(3.0);
  pioneer.bench.run(2.0);
  touch.front = 0x04;
  EXPECT_TRUE(pioneer.bench.run_until(
      2.5, [&] { return pioneer.driver.status().command == Fate::shortened; }));
  EXPECT_TRUE(pioneer.driver.status().bumpers[2]);
  EXPECT_EQ(pioneer.move(0.5), Fate::refused);
  EXPECT_EQ(pioneer.move(-0.3), Fate::done);
  touch.front = 0;
  pioneer.bench.run(0.3);
  pioneer.begin_move(3.0);
  pioneer.bench.run(1.0);
  touch.stalled = true;
  EXPECT_TRUE(pioneer.bench.run_until(
      1.0, [&] { return pioneer.driver.status().command == Fate::aborted; }));
  EXPECT_THAT(pioneer.driver.status().note, ::testing::HasSubstr("stalled"));
}

TEST(P2osDriver, SpoiltBytesCostNoMeasurementAndNoLink) {
  Pioneer pioneer;
  std::mt19937 random(8);
  pioneer.bench.spoil = [&](std::vector<uint8_t>& bytes) {
    if (!bytes.empty() && random() % 300 == 0) bytes[0] = static_cast<uint8_t>(bytes[0] ^ 0x10);
  };
  for (int i = 0; i < 8; ++i) EXPECT_EQ(pioneer.move(0.3), Fate::done);
  pioneer.bench.spoil = nullptr;
  pioneer.bench.run(0.5);
  EXPECT_GT(pioneer.driver.bad_input(), 0);
  EXPECT_NEAR(pioneer.driver.odom_from_robot().x_m, pioneer.robot.reckoned().x_m, 0.003);
}

TEST(P2osDriver, ShutDownLeavesTheMotorsOff) {
  Pioneer pioneer;
  std::vector<uint8_t> last_words;
  pioneer.driver.shut_down(last_words);
  pioneer.robot.receive(last_words, kBaud, pioneer.bench.now());
  EXPECT_FALSE(pioneer.robot.motors_on());
}

TEST(P2osDriver, TurnsItsCameraHeadAndSaysWhereItLooks) {
  P2osOptions options;
  options.camera_head = true;
  P2osEmulator robot;
  P2osBase driver(options);
  testing::Bench<P2osBase> bench(driver, robot, kBaud);
  std::vector<PanTiltState> heads;
  bench.each_step = [&](Utime) {
    for (const PanTiltState& state : driver.take_output().head) heads.push_back(state);
  };
  ASSERT_TRUE(bench.run_until(3.0, [&] { return !heads.empty(); }));
  EXPECT_EQ(heads.back().pan_rad, 0.0);
  PanTiltCommand command;
  command.kind = PanTiltCommand::Kind::go_to;
  command.pan_rad = deg_to_rad(40.0);
  command.tilt_rad = deg_to_rad(-30.0);  // beyond its end
  driver.look(command, bench.now());
  bench.run(2.0);
  EXPECT_NEAR(rad_to_deg(robot.camera_head().pan_rad()), 40.0, 0.1);
  EXPECT_NEAR(rad_to_deg(robot.camera_head().tilt_rad()), -20.0, 0.1);
  EXPECT_NEAR(heads.back().pan_rad, robot.camera_head().pan_rad(), 1e-9);
  EXPECT_NEAR(heads.back().tilt_rad, robot.camera_head().tilt_rad(), 1e-9);
  command.pan_rad = deg_to_rad(-90.0);
  command.pan_rate_rad_per_s = deg_to_rad(10.0);
  driver.look(command, bench.now());
  bench.run(1.0);
  command.kind = PanTiltCommand::Kind::stop;
  driver.look(command, bench.now());
  bench.run(1.0);
  EXPECT_NEAR(rad_to_deg(robot.camera_head().pan_rad()), 30.0, 2.0);
  EXPECT_EQ(driver.bad_input(), 0);
  EXPECT_EQ(driver.status().link, Link::up);
}

}  // namespace
}  // namespace marco::drivers::p2os
