// The expectations of Marco's programs.
#include "common/diagnosis/process/silence_watch.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/sensor_info_t.hpp"

namespace marco::diagnosis {
namespace {

constexpr const char* kRunSlam = "SLAM sends it: start marco-slam, or read its output.";

}  // namespace

Expectation expect_scans(const std::string& pattern, const std::string& channels) {
  Expectation scans;
  scans.what = "scans";
  scans.channels = channels;
  scans.pattern = pattern;
  scans.types = {"bot_core.planar_lidar_t", "marco.lidar_raw_t"};
  scans.meaning = "lidar";
  scans.remedy =
      "Start a laser driver (marco-sick, marco-hokuyo, marco-rplidar, marco-leuze), or play a "
      "log "
      "(`marco replay`).";
  return scans;
}

Expectation expect_odometry() {
  Expectation odometry;
  odometry.what = "odometry";
  odometry.channels = odometry.pattern = channels::kOdometry;
  odometry.types = {"marco.odometry_t"};
  odometry.meaning = "odometry";
  odometry.remedy = "A base's driver sends it (marco-base, marco-p2os).";
  odometry.without = "The map is made from scans alone, which fails in long corridors";
  return odometry;
}

Expectation expect_slam_poses() {
  Expectation poses;
  poses.what = "SLAM's poses";
  poses.channels = poses.pattern = channels::kSlamPose;
  poses.types = {"marco.slam_pose_t"};
  poses.remedy = kRunSlam;
  return poses;
}

Expectation expect_pantilt() {
  Expectation angles;
  angles.what = "the pan-tilt's angles";
  angles.channels = angles.pattern = channels::kPanTiltState;
  angles.types = {"marco.pantilt_state_t"};
  angles.remedy = "The pan-tilt's driver sends them (marco-pantilt, marco-p2os).";
  return angles;
}

Expectation expect_laser_on_pantilt() {
  Expectation laser;
  laser.what = "a laser on a pan-tilt";
  laser.channels = "SENSOR_INFO with mount PANTILT";
  laser.pattern = channels::kSensorInfo;
  laser.types = {"marco.sensor_info_t"};
  laser.remedy = "Set mount = \"pantilt\" in the config of the laser's driver.";
  laser.counts = [](const process::RawMessage& raw) {
    sensor_info_t info;
    return info.decode(raw.bytes.data(), 0, static_cast<int>(raw.bytes.size())) >= 0 &&
           info.mount == sensor_info_t::MOUNT_PANTILT && info.channel.starts_with(channels::kLidar);
  };
  return laser;
}

Expectation expect_map() {
  Expectation map;
  map.what = "a map";
  map.channels = "GRID_MAP or SLAM_POSE";
  map.pattern = "GRID_MAP|SLAM_POSE";
  map.types = {"marco.grid_map_t", "marco.slam_pose_t"};
  map.remedy = kRunSlam;
  return map;
}

Expectation expect_base() {
  Expectation base;
  base.what = "the base";
  base.channels = base.pattern = channels::kBaseStatus;
  base.types = {"marco.base_status_t"};
  base.remedy =
      "Start its driver (marco-base, marco-p2os), or the simulator (`marco run "
      "config/sim.procman`).";
  return base;
}

}  // namespace marco::diagnosis
