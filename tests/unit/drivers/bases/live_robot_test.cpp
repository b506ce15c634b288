#include "simulator/live/live_robot.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"
#include "drivers/hcs12/base_driver.hpp"
#include "lcm_tools/process/config.hpp"

namespace marco::sim {
namespace {

World square_room() {
  WorldSpec spec;
  spec.floor_m = {0, 0, 6, 6};
  WallSpec wall;
  wall.corners_m = {0, 0, 6, 0, 6, 6, 0, 6, 0, 0};
  spec.walls = {wall};
  return build_world(spec);
}

RobotSpec honest_robot() {
  RobotSpec spec;
  spec.wheels.distance_error = spec.wheels.turn_error = spec.wheels.drift_deg_per_m = 0.0;
  spec.wheels.slip_every_m = 0.0;
  return spec;
}

drivers::hcs12::Hcs12BaseOptions unguarded() {
  drivers::hcs12::Hcs12BaseOptions options;
  options.guard.enabled = false;
  return options;
}

/// A driver at the robot's base port; the other devices are stepped along.
struct Drive {
  explicit Drive(LiveRobot& robot)
      : bench(driver, *robot.devices()[0].emulator, drivers::hcs12::kBaud) {
    bench.each_step = [&robot](Utime now) {
      std::vector<uint8_t> out;
      for (std::size_t i = 1; i < robot.devices().size(); ++i) {
        robot.devices()[i].emulator->advance(now, out);
      }
      robot.update(now);
    };
    EXPECT_TRUE(
        bench.run_until(3.0, [this] { return driver.status().link == BaseStatus::Link::up; }));
    bench.run(0.3);
  }
  BaseStatus::Command move(double distance_m) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::move;
    command.distance_m = distance_m;
    command.utime = bench.now();
    driver.command(command, bench.now());
    bench.run_until(30.0,
                    [this] { return driver.status().command != BaseStatus::Command::running; });
    return driver.status().command;
  }

  drivers::hcs12::Hcs12Base driver{unguarded()};
  drivers::testing::Bench<drivers::hcs12::Hcs12Base> bench;
};

TEST(LiveRobot, StandsWhereItsWheelsBroughtIt) {
  const RayCaster rays(square_room());
  LiveRobot robot(rays, honest_robot(), {3.0, 3.0, deg_to_rad(90.0)}, 1);
  Drive drive(robot);
  EXPECT_EQ(drive.move(1.0), BaseStatus::Command::done);
  // To a unit of the base's commands, 1.4 mm, and the clicks of a tick.
  EXPECT_NEAR(robot.world_from_robot().x_m, 3.0, 0.003);
  EXPECT_NEAR(robot.world_from_robot().y_m, 4.0, 0.003);
  EXPECT_NEAR(drive.driver.odom_from_robot().x_m, robot.world_from_robot().y_m - 3.0, 1e-3);
}

TEST(LiveRobot, AWallStopsItWhateverItsWheelsDo) {
  const RayCaster rays(square_room());
  LiveRobot robot(rays, honest_robot(), {3.0, 3.0, 0.0}, 1);
  Drive drive(robot);
  drive.move(2.0);
  drive.move(2.0);
  EXPECT_TRUE(robot.contact().front);
  EXPECT_GT(robot.world_from_robot().x_m, 5.5);
  EXPECT_LT(robot.world_from_robot().x_m, 6.0 - 0.06 - 0.30 + 0.01);  // wall and body
}

TEST(LiveRobot, EveryDeviceRunsWithNobodyConnected) {
  const RayCaster rays(square_room());
  RobotSpec spec;
  spec.base = "p2os";
  spec.track_m = 0.357;
  spec.imu = true;
  for (const char* device : {"sick", "leuze", "leuze_service", "hokuyo", "rplidar", "ld19",
                             "stl27l", "ydlidar_x2", "ydlidar_x4", "ydlidar_g4"}) {
    LiveLaserSpec laser;
    laser.device = device;
    spec.lasers.push_back(laser);
  }
  LiveRobot robot(rays, spec, {3.0, 3.0, 0.0}, 1);
  std::vector<uint8_t> out;
  // The time of day: a device whose clock began at 1970 would work off fifty years here.
  Utime now = Utime::from_us(1'700'000'000'000'000);
  for (int step = 0; step < 200; ++step, now = now + Duration::from_us(2000)) {
    for (const LiveRobot::Device& device : robot.devices()) device.emulator->advance(now, out);
    robot.update(now);
  }
  EXPECT_EQ(robot.devices().size(), 12U);
}

TEST(LiveRobot, TheShippedRobotsCanBeBuilt) {
  const RayCaster rays(square_room());
  const std::pair<const char*, std::size_t> robots[] = {{"create", 2},    {"homemade", 2},
                                                        {"kobuki", 2},    {"marco", 3},
                                                        {"michoacan", 3}, {"two_lasers", 3}};
  for (const auto& [name, devices] : robots) {
    const auto spec =
        process::load_options<RobotSpec>(std::string("config/robots/") + name + ".toml");
    EXPECT_EQ(LiveRobot(rays, spec, {3.0, 3.0, 0.0}, 1).devices().size(), devices) << name;
  }
}

TEST(LiveRobot, RefusesARobotThatCannotBe) {
  const RayCaster rays(square_room());
  RobotSpec spec;
  spec.base = "legs";
  EXPECT_THROW(LiveRobot(rays, spec, {}, 1), std::invalid_argument);
  spec = {};
  spec.lasers.emplace_back().mount = "pantilt";  // there is none
  EXPECT_THROW(LiveRobot(rays, spec, {}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace marco::sim
