#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "hcs12_base.hpp"

namespace marco::drivers::hcs12 {
namespace {

using testing::Hcs12OnBench;
using Fate = BaseStatus::Command;

TEST(Hcs12Driver, CountsEveryMoveToTheClick) {
  Hcs12OnBench base;
  int moves = 0;
  const int64_t bad_before = base.driver.bad_input();  // its first words met a reset
  for (const double speed : {0.4, 0.1, 0.9}) {
    base.speed(speed);
    for (const double distance : {0.5, -0.3, 2.0, 0.02}) {
      EXPECT_EQ(base.move(distance), Fate::done) << distance << " m at " << speed;
      EXPECT_LE(base.clicks_off(), ++moves * 1.0) << distance << " m at " << speed;
    }
    for (const double angle : {1.5, -0.7}) {
      EXPECT_EQ(base.turn(angle), Fate::done) << angle << " rad at " << speed;
      EXPECT_LE(base.clicks_off(), ++moves * 1.0) << angle << " rad at " << speed;
    }
  }
  EXPECT_EQ(base.driver.bad_input(), bad_before);
  EXPECT_EQ(base.driver.timeouts(), 0);
}

TEST(Hcs12Driver, DrivesASquareBackToItsStart) {
  Hcs12OnBench base;
  for (int side = 0; side < 4; ++side) {
    ASSERT_EQ(base.move(1.0), Fate::done);
    ASSERT_EQ(base.turn(deg_to_rad(90.0)), Fate::done);
  }
  // A unit of a command is 1.4 mm, a tick at top speed 0.4 mm: that and its lever over the square.
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, 0.0, 0.02);
  EXPECT_NEAR(base.driver.odom_from_robot().y_m, 0.0, 0.02);
  EXPECT_NEAR(base.driver.odom_from_robot().theta_rad, 0.0, 0.03);
}

// @returns how far odometry is from the counters at most, while the base drives 2 m.
double worst_on_the_way_m(Hcs12OnBench& base) {
  base.odometry.clear();
  double worst_m = 0.0;
  const double click_m = std::numbers::pi * 0.3 / 65500.0;
  auto remember = base.bench.each_step;
  base.bench.each_step = [&](Utime now) {
    const std::size_t before = base.odometry.size();
    remember(now);
    if (base.odometry.size() == before) return;
    const double true_m = (base.board.left_clicks() + base.board.right_clicks()) / 2.0 * click_m;
    worst_m = std::max(worst_m, std::abs(base.driver.odom_from_robot().x_m - true_m));
  };
  EXPECT_EQ(base.move(2.0), Fate::done);
  base.bench.each_step = remember;
  return worst_m;
}

TEST(Hcs12Driver, OdometryFollowsAFastMoveAndNeverRunsBackInTime) {
  Hcs12OnBench base;
  for (const double way_m : {2.0, -2.0, 2.0, -2.0}) EXPECT_EQ(base.move(way_m), Fate::done);
  // The firmware's ramp, paced as the moves before have shown: 3 % of a metre between readings.
  EXPECT_LT(worst_on_the_way_m(base), 0.03);
  EXPECT_GT(base.odometry.size(), 60U);
  for (std::size_t i = 1; i < base.odometry.size(); ++i) {
    EXPECT_LT(base.odometry[i - 1].utime, base.odometry[i].utime);
  }
}

// The answer that the wheels rest was read seconds late.
TEST(Hcs12Driver, AProcessThatStoodStillLearnsNoPaceFromIt) {
  Hcs12OnBench base;
  for (const double way_m : {2.0, -2.0, 2.0, -2.0}) EXPECT_EQ(base.move(way_m), Fate::done);
  base.begin_move(-2.0);
  base.bench.run(2.0);
  base.bench.frozen = true;
  base.bench.run(5.0);
  base.bench.frozen = false;
  base.bench.run(2.0);
  ASSERT_NE(base.driver.status().command, Fate::running);
  EXPECT_LE(base.clicks_off(), 5.0);
  EXPECT_LT(worst_on_the_way_m(base), 0.03);
}

TEST(Hcs12Driver, GoesToAPoint) {
  Hcs12OnBench base;
  BaseCommand command;
  command.kind = BaseCommand::Kind::go_to;
  command.point_m = {-0.5, 0.8};
  EXPECT_EQ(base.order(command), Fate::done);
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, -0.5, 0.01);
  EXPECT_NEAR(base.driver.odom_from_robot().y_m, 0.8, 0.01);
}

TEST(Hcs12Driver, AVelocityThatIsNotRepeatedEndsByItself) {
  Hcs12OnBench base;
  base.velocity(0.1, 0.0);
  base.bench.run(0.45);
  EXPECT_TRUE(base.board.motors_on());
  const double at_timeout = base.board.left_clicks();
  base.bench.run(0.05);
  // 0.5 s after the order, and the time of one exchange on the line.
  EXPECT_TRUE(base.bench.run_until(0.15, [&] { return !base.board.motors_on(); }));
  EXPECT_GT(at_timeout, 1000.0);
  base.bench.run(0.3);
  EXPECT_EQ(base.driver.status().command, Fate::done);
  EXPECT_LE(base.clicks_off(), 1.0);
}

TEST(Hcs12Driver, VelocitiesThatAreRepeatedGoOnAndChange) {
  Hcs12OnBench base;
  for (int i = 0; i < 20; ++i) {
    base.velocity(0.1, 0.0);
    base.bench.run(0.1);
  }
  EXPECT_GT(base.driver.odom_from_robot().x_m, 0.1);
  for (int i = 0; i < 20; ++i) {
    base.velocity(0.0, -0.4);
    base.bench.run(0.1);
  }
  EXPECT_LT(base.driver.odom_from_robot().theta_rad, -0.4);
  base.velocity(0.0, 0.0);
  base.bench.run(0.3);
  EXPECT_FALSE(base.board.motors_on());
  // Six renewals; at each the counters begin again, and 24 ms of the way are guessed by the speed:
  // 170 clicks, to a fifth.
  EXPECT_LE(base.clicks_off(), 6 * 34.0);
}

TEST(Hcs12Driver, AStopOrderStopsAtOnce) {
  Hcs12OnBench base;
  base.begin_move(5.0);
  base.bench.run(2.0);
  ASSERT_TRUE(base.board.motors_on());
  const int64_t stop = base.begin(BaseCommand{});
  EXPECT_TRUE(base.bench.run_until(0.1, [&] { return !base.board.motors_on(); }));
  base.bench.run(0.3);
  EXPECT_EQ(base.driver.status().command_id, stop);
  EXPECT_EQ(base.driver.status().command, Fate::done);
  EXPECT_LE(base.clicks_off(), 1.0);
}

TEST(Hcs12Driver, ReadsSonarsAndBatteries) {
  BaseWorld world;
  world.sonar_range_m = [](std::size_t transducer) {
    return transducer == 4 ? HUGE_VAL : 2.0 + 0.1 * static_cast<double>(transducer);
  };
  world.battery_v = [] { return std::array<double, 4>{12.5, 25.0, 12.6, 25.2}; };
  Hcs12OnBench base({}, world);
  base.bench.run(4.0);
  ASSERT_GE(base.rings.size(), 2U);
  const SonarRing& ring = base.rings.back();
  ASSERT_EQ(ring.readings.size(), 16U);
  EXPECT_NEAR(ring.readings[2].range_m, 2.2, 0.001);
  EXPECT_EQ(ring.readings[4].range_m, 0.0);
  EXPECT_NEAR(ring.readings[4].robot_from_sonar.theta_rad, deg_to_rad(90.0), 1e-9);
  ASSERT_EQ(base.driver.status().battery_v.size(), 4U);
  EXPECT_NEAR(base.driver.status().battery_v[1], 25.0, 0.04);
}

/// A wall across the way, as a laser sees it.
LaserScan wall_at(double distance_m, Utime now) {
  LaserScan scan;
  scan.utime = now;
  scan.first_bearing_rad = deg_to_rad(-60.0);
  scan.bearing_step_rad = deg_to_rad(1.0);
  for (std::size_t beam = 0; beam <= 120; ++beam) {
    scan.ranges_m.push_back(static_cast<float>(distance_m / std::cos(scan.bearing_rad(beam))));
  }
  return scan;
}

TEST(Hcs12Driver, TheGuardRefusesAndShortensMoves) {
  Hcs12OnBench base;
  base.sees = false;  // another laser does
  base.driver.guard().forget_sensors();
  SensorInfo info;
  info.parent_from_sensor = make_pose3({0.1, 0.0, 0.5});
  base.driver.guard().on_sensor_info(info);
  auto remember = base.bench.each_step;
  double wall_m = 1.0;  // from the start of the run, along x
  base.bench.each_step = [&](Utime now) {
    remember(now);
    const Pose2& pose = base.driver.odom_from_robot();
    base.driver.guard().on_scan(wall_at(wall_m - pose.x_m - 0.1, now), pose, now);
  };
  base.bench.run(0.2);
  EXPECT_EQ(base.move(2.0), Fate::shortened);
  // Front 0.30 m and margin 0.10 m before the wall.
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, 0.60, 0.01);
  EXPECT_EQ(base.move(0.5), Fate::refused);
  EXPECT_EQ(base.move(-0.3), Fate::done) << base.driver.status().note;
  wall_m = 3.0;
  base.bench.run(0.1);
  // The wall jumps near in mid-move.
  base.begin_move(1.5);
  base.bench.run(1.5);
  wall_m = base.driver.odom_from_robot().x_m + 0.5;
  EXPECT_TRUE(
      base.bench.run_until(1.0, [&] { return base.driver.status().command == Fate::shortened; }));
  EXPECT_LT(base.driver.odom_from_robot().x_m + 0.30, wall_m);
}

TEST(Hcs12Driver, TheGuardCanBeSwitchedOff) {
  Hcs12BaseOptions options;
  options.guard.enabled = false;
  Hcs12OnBench base(options);
  SensorInfo info;
  info.parent_from_sensor = make_pose3({0.1, 0.0, 0.5});
  base.driver.guard().on_sensor_info(info);
  base.driver.guard().on_scan(wall_at(0.5, base.bench.now()), {}, base.bench.now());
  EXPECT_EQ(base.move(0.5), Fate::done);
}

}  // namespace
}  // namespace marco::drivers::hcs12
