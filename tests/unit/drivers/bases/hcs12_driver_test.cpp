#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bench.hpp"
#include "drivers/hcs12/base_driver.hpp"
#include "drivers/hcs12/base_emulator.hpp"

namespace marco::drivers::hcs12 {
namespace {

using Fate = BaseStatus::Command;
using Link = BaseStatus::Link;

/// A base on a bench with its driver up; remembers all it said.
struct Base {
  explicit Base(const Hcs12BaseOptions& options = {}, BaseWorld world = {})
      : board(std::move(world), {}), driver(options), bench(driver, board, 9600) {
    bench.each_step = [this](Utime) {
      BaseOutput output = driver.take_output();
      for (auto& sample : output.odometry) odometry.push_back(sample);
      for (auto& ring : output.sonar) rings.push_back(ring);
    };
    EXPECT_TRUE(bench.run_until(3.0, [this] { return driver.status().link == Link::up; }));
    bench.run(0.3);
  }
  /// Gives an order and waits for its end. @returns its fate.
  Fate order(BaseCommand command, double patience_s = 60.0) {
    command.id = ++id;
    driver.command(command, bench.now());
    bench.run_until(patience_s, [this] { return driver.status().command != Fate::running; });
    return driver.status().command;
  }
  Fate move(double distance_m) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::move;
    command.distance_m = distance_m;
    return order(command);
  }
  Fate turn(double angle_rad) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::turn;
    command.angle_rad = angle_rad;
    return order(command);
  }
  void velocity(double v, double w) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::velocity;
    command.id = ++id;
    command.velocity_m_per_s = v;
    command.yaw_rate_rad_per_s = w;
    driver.command(command, bench.now());
  }
  void speed(double metres_per_s) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::set_speed;
    command.max_velocity_m_per_s = metres_per_s;
    command.max_yaw_rate_rad_per_s = metres_per_s / 0.25;
    order(command);
  }
  double clicks_off() const {
    return std::max(std::abs(board.left_clicks() - static_cast<double>(driver.left_clicks())),
                    std::abs(board.right_clicks() - static_cast<double>(driver.right_clicks())));
  }

  BaseEmulator board;
  Hcs12Base driver;
  testing::Bench<Hcs12Base> bench;
  std::vector<OdometrySample> odometry;
  std::vector<SonarRing> rings;
  int64_t id = 0;
};

TEST(Hcs12Driver, CountsEveryMoveToTheClick) {
  Base base;
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
  Base base;
  for (int side = 0; side < 4; ++side) {
    ASSERT_EQ(base.move(1.0), Fate::done);
    ASSERT_EQ(base.turn(deg_to_rad(90.0)), Fate::done);
  }
  // A unit of a command is 1.4 mm, a tick at top speed 0.4 mm: that and its lever over the square.
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, 0.0, 0.02);
  EXPECT_NEAR(base.driver.odom_from_robot().y_m, 0.0, 0.02);
  EXPECT_NEAR(base.driver.odom_from_robot().theta_rad, 0.0, 0.03);
}

TEST(Hcs12Driver, OdometryFollowsAFastMoveAndNeverRunsBackInTime) {
  Base base;
  for (const double way_m : {2.0, -2.0, 2.0, -2.0}) EXPECT_EQ(base.move(way_m), Fate::done);
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
  EXPECT_GT(base.odometry.size(), 60U);
  // The firmware's ramp, paced as the moves before have shown: 3 % of a metre between readings.
  EXPECT_LT(worst_m, 0.03);
  for (std::size_t i = 1; i < base.odometry.size(); ++i) {
    EXPECT_LT(base.odometry[i - 1].utime, base.odometry[i].utime);
  }
}

TEST(Hcs12Driver, GoesToAPoint) {
  Base base;
  BaseCommand command;
  command.kind = BaseCommand::Kind::go_to;
  command.point_m = {-0.5, 0.8};
  EXPECT_EQ(base.order(command), Fate::done);
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, -0.5, 0.01);
  EXPECT_NEAR(base.driver.odom_from_robot().y_m, 0.8, 0.01);
}

TEST(Hcs12Driver, AVelocityThatIsNotRepeatedEndsByItself) {
  Base base;
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
  Base base;
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
  EXPECT_LE(base.clicks_off(), 2.0);
}

TEST(Hcs12Driver, AStopOrderStopsAtOnce) {
  Base base;
  BaseCommand command;
  command.kind = BaseCommand::Kind::move;
  command.distance_m = 5.0;
  command.id = 77;
  base.driver.command(command, base.bench.now());
  base.bench.run(2.0);
  ASSERT_TRUE(base.board.motors_on());
  BaseCommand stop;
  stop.id = 78;
  base.driver.command(stop, base.bench.now());
  EXPECT_TRUE(base.bench.run_until(0.1, [&] { return !base.board.motors_on(); }));
  base.bench.run(0.3);
  EXPECT_EQ(base.driver.status().command_id, 78);
  EXPECT_EQ(base.driver.status().command, Fate::done);
  EXPECT_LE(base.clicks_off(), 1.0);
}

TEST(Hcs12Driver, AResetEndsTheMoveAndTheNextOneWorks) {
  Base base;
  BaseCommand command;
  command.kind = BaseCommand::Kind::move;
  command.distance_m = 2.0;
  command.id = 5;
  base.driver.command(command, base.bench.now());
  base.bench.run(1.5);
  const int64_t resets = base.driver.resets();
  base.board.reset(base.bench.now());
  EXPECT_TRUE(base.bench.run_until(0.2, [&] { return base.driver.resets() > resets; }));
  EXPECT_EQ(base.driver.status().command, Fate::aborted);
  EXPECT_TRUE(base.bench.run_until(1.0, [&] { return base.driver.status().link == Link::up; }));
  base.bench.run(0.3);
  EXPECT_EQ(base.move(0.2), Fate::done);
}

TEST(Hcs12Driver, AMoveEndsThoughTheAnswerToItsEndWasLost) {
  Base base;
  BaseCommand command;
  command.kind = BaseCommand::Kind::move;
  command.distance_m = 2.0;  // fast: the firmware says when the wheels rest, and nothing before
  command.id = 5;
  base.driver.command(command, base.bench.now());
  base.bench.run(1.5);
  base.bench.deaf = true;
  base.bench.spoil = [](std::vector<uint8_t>& bytes) { bytes.clear(); };
  base.bench.run(8.0);  // by then the wheels rest
  base.bench.deaf = false;
  base.bench.spoil = nullptr;
  // The walk's own time, a quarter more, a second, and the rest of the way if there is one.
  EXPECT_TRUE(
      base.bench.run_until(12.0, [&] { return base.driver.status().command != Fate::running; }));
  EXPECT_EQ(base.driver.status().command, Fate::done);
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, 2.0, 0.02);
}

TEST(Hcs12Driver, ASilentBoardIsToldAndTakenUpAgain) {
  Base base;
  base.bench.deaf = true;
  EXPECT_TRUE(base.bench.run_until(2.0, [&] { return base.driver.status().link == Link::down; }));
  BaseCommand command;
  command.kind = BaseCommand::Kind::move;
  command.distance_m = 0.2;
  EXPECT_EQ(base.order(command, 0.1), Fate::refused);
  base.bench.deaf = false;
  EXPECT_TRUE(base.bench.run_until(2.0, [&] { return base.driver.status().link == Link::up; }));
  base.bench.run(0.3);
  EXPECT_EQ(base.move(0.2), Fate::done);
}

TEST(Hcs12Driver, APulledPlugEndsTheMove) {
  Base base;
  BaseCommand command;
  command.kind = BaseCommand::Kind::move;
  command.distance_m = 2.0;
  base.driver.command(command, base.bench.now());
  base.bench.run(1.0);
  base.bench.plug(false);
  base.bench.run(0.1);
  EXPECT_EQ(base.driver.status().command, Fate::aborted);
  EXPECT_EQ(base.driver.status().link, Link::down);
  base.bench.plug(true);
  EXPECT_TRUE(base.bench.run_until(2.0, [&] { return base.driver.status().link == Link::up; }));
  // The board knows nothing of plugs: it is the driver that stops it on its return.
  EXPECT_TRUE(base.bench.run_until(0.3, [&] { return !base.board.motors_on(); }));
}

TEST(Hcs12Driver, SpoiltBytesAreCountedAndOutlived) {
  Base base;
  std::mt19937 random(3);
  base.bench.spoil = [&](std::vector<uint8_t>& bytes) {
    if (bytes.empty()) return;
    const auto dice = random() % 60;
    if (dice == 0) bytes[0] = static_cast<uint8_t>(bytes[0] ^ (1U << (random() % 8)));
    if (dice == 1) bytes.erase(bytes.begin());
    if (dice == 2) bytes.push_back(static_cast<uint8_t>(random()));
  };
  for (int i = 0; i < 10; ++i) base.move(0.3);
  EXPECT_GT(base.driver.bad_input() + base.driver.timeouts(), 5);
  base.bench.spoil = nullptr;
  base.bench.run(3.0);
  EXPECT_EQ(base.driver.status().link, Link::up);
  EXPECT_EQ(base.move(0.3), Fate::done);
}

TEST(Hcs12Driver, ShutDownLeavesTheMotorsOff) {
  Base base;
  BaseCommand command;
  command.kind = BaseCommand::Kind::move;
  command.distance_m = 2.0;
  base.driver.command(command, base.bench.now());
  base.bench.run(1.0);
  ASSERT_TRUE(base.board.motors_on());
  std::vector<uint8_t> last_words;
  base.driver.shut_down(last_words);
  base.board.receive(last_words, 9600, base.bench.now());
  std::vector<uint8_t> out;
  base.board.advance(base.bench.now() + Duration::from_seconds(0.01), out);
  EXPECT_FALSE(base.board.motors_on());
}

TEST(Hcs12Driver, ReadsSonarsAndBatteries) {
  BaseWorld world;
  world.sonar_range_m = [](std::size_t transducer) {
    return transducer == 4 ? HUGE_VAL : 2.0 + 0.1 * static_cast<double>(transducer);
  };
  world.battery_v = [] { return std::array<double, 4>{12.5, 25.0, 12.6, 25.2}; };
  Base base({}, world);
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
LaserScan wall_at(double distance_m) {
  LaserScan scan;
  scan.first_bearing_rad = deg_to_rad(-60.0);
  scan.bearing_step_rad = deg_to_rad(1.0);
  for (std::size_t beam = 0; beam <= 120; ++beam) {
    scan.ranges_m.push_back(static_cast<float>(distance_m / std::cos(scan.bearing_rad(beam))));
  }
  return scan;
}

TEST(Hcs12Driver, TheGuardRefusesAndShortensMoves) {
  Base base;
  SensorInfo info;
  info.parent_from_sensor = make_pose3({0.1, 0.0, 0.5});
  base.driver.guard().on_sensor_info(info);
  auto remember = base.bench.each_step;
  double wall_m = 1.0;  // from the start of the run, along x
  base.bench.each_step = [&](Utime now) {
    remember(now);
    const Pose2& pose = base.driver.odom_from_robot();
    base.driver.guard().on_scan(wall_at(wall_m - pose.x_m - 0.1), pose, now);
  };
  base.bench.run(0.2);
  EXPECT_EQ(base.move(2.0), Fate::shortened);
  // Front 0.30 m and margin 0.10 m before the wall.
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, 0.60, 0.01);
  EXPECT_EQ(base.move(0.5), Fate::refused);
  EXPECT_EQ(base.move(-0.3), Fate::done);
  wall_m = 3.0;
  base.bench.run(0.1);
  // The wall jumps near in mid-move.
  BaseCommand command;
  command.kind = BaseCommand::Kind::move;
  command.distance_m = 1.5;
  base.driver.command(command, base.bench.now());
  base.bench.run(1.5);
  wall_m = base.driver.odom_from_robot().x_m + 0.5;
  EXPECT_TRUE(
      base.bench.run_until(1.0, [&] { return base.driver.status().command == Fate::shortened; }));
  EXPECT_LT(base.driver.odom_from_robot().x_m + 0.30, wall_m);
}

TEST(Hcs12Driver, TheGuardCanBeSwitchedOff) {
  Hcs12BaseOptions options;
  options.guard.enabled = false;
  Base base(options);
  SensorInfo info;
  info.parent_from_sensor = make_pose3({0.1, 0.0, 0.5});
  base.driver.guard().on_sensor_info(info);
  base.driver.guard().on_scan(wall_at(0.5), {}, base.bench.now());
  EXPECT_EQ(base.move(0.5), Fate::done);
}

}  // namespace
}  // namespace marco::drivers::hcs12
