#pragma once

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "bench.hpp"
#include "drivers/base/base_driver.hpp"

namespace marco::drivers::testing {

/// A base on a bench with its driver up; remembers all it said. It has a laser, which sees walls
/// far away.
template <class Driver>
class DrivenBase {
 public:
  DrivenBase(Driver& driver, Emulator& emulator, int baud)
      : bench(driver, emulator, baud), driver_(driver) {
    SensorInfo mount;
    mount.parent_from_sensor.translation().z() = 0.3;
    driver_.guard().on_sensor_info(mount);
    bench.each_step = [this](Utime) {
      look();
      BaseOutput output = driver_.take_output();
      for (auto& sample : output.odometry) odometry.push_back(sample);
      for (auto& ring : output.sonar) rings.push_back(ring);
      for (auto& sample : output.imu) imu.push_back(sample);
    };
    EXPECT_TRUE(comes_up(3.0));
    bench.run(0.3);
  }

  bool comes_up(double within_s) {
    return bench.run_until(within_s,
                           [this] { return driver_.status().link == BaseStatus::Link::up; });
  }

  /// Gives an order. @returns its id.
  int64_t begin(BaseCommand command) {
    command.id = ++id_;
    if (command.utime == Utime{}) command.utime = bench.host_now();
    driver_.command(command, bench.host_now());
    return id_;
  }
  int64_t begin_move(double distance_m) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::move;
    command.distance_m = distance_m;
    return begin(command);
  }
  void velocity(double v, double w) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::velocity;
    command.velocity_m_per_s = v;
    command.yaw_rate_rad_per_s = w;
    begin(command);
  }

  /// Gives an order and waits for its end. @returns its fate.
  BaseStatus::Command order(const BaseCommand& command, double patience_s = 60.0) {
    begin(command);
    return end(patience_s);
  }
  BaseStatus::Command move(double distance_m, double patience_s = 60.0) {
    begin_move(distance_m);
    return end(patience_s);
  }
  BaseStatus::Command turn(double angle_rad) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::turn;
    command.angle_rad = angle_rad;
    return order(command);
  }

  Bench<Driver> bench;
  std::vector<OdometrySample> odometry;
  std::vector<SonarRing> rings;
  std::vector<ImuSample> imu;

  bool sees = true;  ///< the laser's scans come

 private:
  void look() {
    if (!sees || bench.now() < next_scan_) return;
    next_scan_ = bench.now() + Duration::from_us(100'000);
    LaserScan scan;
    scan.utime = bench.host_now();
    scan.first_bearing_rad = -std::numbers::pi;
    scan.bearing_step_rad = deg_to_rad(2.0);
    scan.ranges_m.assign(180, 8.0F);
    driver_.guard().on_scan(scan, driver_.odom_from_robot(), bench.host_now());
  }
  BaseStatus::Command end(double patience_s) {
    bench.run_until(patience_s,
                    [this] { return driver_.status().command != BaseStatus::Command::running; });
    return driver_.status().command;
  }

  Driver& driver_;
  int64_t id_ = 0;
  Utime next_scan_;
};

}  // namespace marco::drivers::testing
