#pragma once

#include <gmock/gmock.h>

#include <random>
#include <string>
#include <vector>

#include "lcm_tools/process/batch_bus.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "slam/process/slam_adapter.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::slam {

using ::marco::testing::TemporaryFolder;

/// Drives a SlamAdapter through a room.
class SlamAdapterFixture : public ::testing::Test {
 protected:
  // 60 scans along a bow.
  SlamAdapterFixture() { record({0.08, 0, 0.02}, 60); }
  // So many steps, odometry 3 % long and a little later than each scan.
  void record(const Pose2& step, int count) {
    samples_.clear();
    std::mt19937 random(5);
    SensorInfo info;
    info.parent_from_sensor = make_pose3({0.1, 0.0, 0.3});
    samples_.emplace_back(info);
    Pose2 truth{-3.0, -2.0, 0.2}, odom;
    for (int i = 0; i < count; ++i) {
      truth = truth * step;
      odom = odom * Pose2{1.03 * step.x_m, 0, step.theta_rad};
      LaserScan scan = room_.scan(truth * Pose2{0.1, 0, 0}, 0.01, &random);
      scan.utime = Utime::from_us(1'000'000 + i * 200'000);
      samples_.emplace_back(scan);
      OdometrySample odometry;
      odometry.utime = scan.utime + Duration::from_us(30'000);
      odometry.odom_from_robot = odom;
      samples_.emplace_back(odometry);
    }
  }
  static void send(process::BatchBus& bus, const Sample& sample) {
    const EncodedMessage message = encode_sample(sample);
    bus.deliver(message.channel, message.bytes, message.utime);
  }
  Trajectory run_whole() {
    process::BatchBus bus;
    SlamAdapter slam(bus, {});
    for (const Sample& sample : samples_) send(bus, sample);
    slam.finish();
    odometry_ = slam.odometry_trajectory();
    return slam.slam().trajectory();
  }
  static void set_pose(process::BatchBus& bus, const Pose2& pose) {
    slam_command_t message = {};
    message.command = slam_command_t::SET_POSE;
    message.x_m = pose.x_m;
    message.y_m = pose.y_m;
    message.theta_rad = pose.theta_rad;
    bus.deliver(channels::kSlamCommand, encode_message(message), Utime::from_us(1));
  }
  static void order(process::BatchBus& bus, int8_t command, const std::string& folder = "") {
    slam_command_t message = {};
    message.command = command;
    message.folder = folder;
    bus.deliver(channels::kSlamCommand, encode_message(message), Utime::from_us(1));
  }
  testing::FlatWorld room_ = testing::small_room();
  std::vector<Sample> samples_;
  Trajectory odometry_;  ///< of the whole run
  TemporaryFolder folder_;
};

}  // namespace marco::slam
