#pragma once

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/input/sensor_synchronizer.hpp"
#include "lcmtypes/channels.hpp"

namespace marco {

/// A synchronizer that is fed by hand. A laser on the robot is announced.
class SensorSynchronizerTest : public ::testing::Test {
 protected:
  SensorSynchronizerTest() { announce(channels::kLidar); }

  void announce(const std::string& channel,
                SensorInfo::Mount mount = SensorInfo::Mount::robot,
                double duration_s = 0.0) {
    SensorInfo info;
    info.channel = channel;
    info.mount = mount;
    info.scan_duration_s = duration_s;
    input_.add(info);
  }
  void scan(double seconds, const std::string& channel = channels::kLidar) {
    LaserScan scan;
    scan.utime = Utime::from_seconds(seconds);
    scan.channel = channel;
    scan.ranges_m = {1.0F, 2.0F};
    input_.add(std::move(scan));
  }
  void odometry(double seconds, const Pose2& pose) {
    OdometrySample sample;
    sample.utime = Utime::from_seconds(seconds);
    sample.odom_from_robot = pose;
    input_.add(sample);
  }
  void pantilt(double seconds, double pan_rad, double tilt_rad) {
    PanTiltState state;
    state.utime = Utime::from_seconds(seconds);
    state.pan_rad = pan_rad;
    state.tilt_rad = tilt_rad;
    input_.add(state);
  }
  std::vector<SynchronizedScan> take() {
    std::vector<SynchronizedScan> scans;
    while (auto scan = input_.next()) scans.push_back(std::move(*scan));
    return scans;
  }

  std::map<std::string, int> drops_;
  SensorSynchronizer input_{{},
                            {channels::kPanTiltState, &channels::lidar_of},
                            [this](const std::string& cause) { ++drops_[cause]; }};
};

}  // namespace marco
