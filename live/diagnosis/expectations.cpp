// What Marco's programs wait for, and where it comes from.
#include "lcmtypes/channels.hpp"
#include "live/diagnosis/silence_watch.hpp"
#include "marco/sensor_info_t.hpp"

namespace marco::diagnosis {
namespace {

constexpr const char* kRunSlam = "SLAM publishes it: start marco-slam, or read its output.";

bool is_laser_on_pantilt(const process::RawMessage& raw) {
  sensor_info_t info;
  return info.decode(raw.bytes.data(), 0, static_cast<int>(raw.bytes.size())) >= 0 &&
         info.mount == sensor_info_t::MOUNT_PANTILT && info.channel.starts_with(channels::kLidar);
}

}  // namespace

Expectation expect(Awaited what) {
  static const std::map<Awaited, Expectation> kAll = {
      {Awaited::odometry,
       {.what = "odometry",
        .channels = channels::kOdometry,
        .pattern = channels::kOdometry,
        .types = {"marco.odometry_t"},
        .meaning = "odometry",
        .remedy = "A base driver publishes it (marco-base, marco-p2os).",
        .without = "The map is made from scans alone, which fails in long corridors"}},
      {Awaited::slam_poses,
       {.what = "SLAM's poses",
        .channels = channels::kSlamPose,
        .pattern = channels::kSlamPose,
        .types = {"marco.slam_pose_t"},
        .remedy = kRunSlam}},
      {Awaited::pantilt,
       {.what = "the pan-tilt's angles",
        .channels = channels::kPanTiltState,
        .pattern = channels::kPanTiltState,
        .types = {"marco.pantilt_state_t"},
        .remedy = "The pan-tilt's driver publishes them (marco-pantilt, marco-p2os)."}},
      {Awaited::laser_on_pantilt,
       {.what = "a laser on a pan-tilt",
        .channels = "SENSOR_INFO with mount PANTILT",
        .pattern = channels::kSensorInfo,
        .types = {"marco.sensor_info_t"},
        .remedy = "Set mount = \"pantilt\" in the config of the laser's driver.",
        .counts = is_laser_on_pantilt}},
      {Awaited::map,
       {.what = "a map",
        .channels = "GRID_MAP or SLAM_POSE",
        .pattern = "GRID_MAP|SLAM_POSE",
        .types = {"marco.grid_map_t", "marco.slam_pose_t"},
        .remedy = kRunSlam}},
      {Awaited::base,
       {.what = "the base",
        .channels = channels::kBaseStatus,
        .pattern = channels::kBaseStatus,
        .types = {"marco.base_status_t"},
        .remedy = "Start its driver (marco-base, marco-p2os), or the simulator (`marco run "
                  "config/sim.procman`)."}}};
  return kAll.at(what);
}

Expectation expect_scans(const std::string& pattern, const std::string& channels) {
  return {.what = "scans",
          .channels = channels,
          .pattern = pattern,
          .types = {"bot_core.planar_lidar_t", "marco.lidar_raw_t"},
          .meaning = "lidar",
          .remedy =
              "Start a laser's driver (marco-sick, marco-hokuyo, marco-rplidar, "
              "marco-ldlidar, marco-ydlidar, marco-leuze, marco-cola), or play a log (`marco "
              "replay`)."};
}

}  // namespace marco::diagnosis
