#include "tools/evaluate/true_beams.hpp"

#include <cmath>
#include <map>

#include "common/pose_buffer.hpp"
#include "lcm_tools/base/check.hpp"
#include "recordings/recording.hpp"

namespace marco {
namespace {

constexpr std::size_t kAll = 100'000'000;

struct Heard {
  std::map<std::string, SensorInfo> sensors;
  PoseBuffer poses{kAll};
  PoseBuffer pantilt{kAll};  ///< pan as x_m, tilt as y_m [rad]
  std::vector<LaserScan> scans;
  Trajectory truth;
};

Heard hear(const std::filesystem::path& path) {
  Heard heard;
  double pan_rad = 0.0;
  const auto recording = open_recording(path);
  while (const auto sample = recording->next()) {
    if (const auto* info = std::get_if<SensorInfo>(&*sample)) heard.sensors[info->channel] = *info;
    if (const auto* pose = std::get_if<TruePose>(&*sample)) {
      heard.poses.add(pose->utime, pose->world_from_robot);
      heard.truth.push_back({pose->utime, pose->world_from_robot});
    }
    if (const auto* state = std::get_if<PanTiltState>(&*sample)) {
      // Unwrapped: a pan that turns on and on is interpolated as a length.
      pan_rad += normalize_angle(state->pan_rad - pan_rad);
      heard.pantilt.add(state->utime, {pan_rad, state->tilt_rad, 0.0});
    }
    if (const auto* scan = std::get_if<LaserScan>(&*sample)) heard.scans.push_back(*scan);
  }
  return heard;
}

}  // namespace

TrueBeams true_beams(const std::filesystem::path& recording, const sim::RayCaster& world) {
  constexpr double kMovingRad = 1e-4;
  const Heard heard = hear(recording);
  require(!heard.truth.empty(), recording.string() + ": contains no TRUE_POSE");
  TrueBeams beams;
  beams.truth = heard.truth;
  const auto base = heard.sensors.find("PANTILT_STATE");
  const bool has_pantilt = base != heard.sensors.end();
  for (const LaserScan& scan : heard.scans) {
    const auto info = heard.sensors.find(scan.channel);
    if (info == heard.sensors.end()) continue;
    const bool on_pantilt = has_pantilt && info->second.mount == SensorInfo::Mount::pantilt;
    if (!on_pantilt && !is_steep(info->second.parent_from_sensor)) continue;
    const Utime last = scan.utime + Duration::from_seconds(info->second.scan_duration_s);
    const auto pose = heard.poses.at(scan.utime), pose_last = heard.poses.at(last);
    const auto angles_at = [&](Utime utime) -> std::optional<Pose2> {
      return on_pantilt ? heard.pantilt.at(utime) : Pose2{};
    };
    const auto from = angles_at(scan.utime), to = angles_at(last);
    if (!pose || !pose_last || !from || !to) continue;
    const double moved_rad = std::hypot(to->x_m - from->x_m, to->y_m - from->y_m);
    const double drove_m = (pose_last->translation_m() - pose->translation_m()).norm();
    // A steep laser sweeps by the robot's motion, others by the pan-tilt's of a robot that stands.
    if (on_pantilt ? moved_rad < kMovingRad || drove_m > 1e-4 : drove_m < 1e-4) continue;
    ++beams.scans;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const auto range_m = static_cast<double>(scan.ranges_m[i]);
      if (!(range_m > info->second.range_min_m && range_m < info->second.range_max_m)) continue;
      const double part = static_cast<double>(i) / static_cast<double>(scan.size() - 1);
      const Pose3 sensor =
          lift(interpolate(*pose, *pose_last, part)) *
          (on_pantilt ? robot_from_pantilt_sensor(base->second, info->second,
                                                  from->x_m + part * (to->x_m - from->x_m),
                                                  from->y_m + part * (to->y_m - from->y_m))
                      : info->second.parent_from_sensor);
      const double bearing =
          scan.first_bearing_rad + static_cast<double>(i) * scan.bearing_step_rad;
      const Eigen::Vector3f way =
          (sensor.linear() * Eigen::Vector3d(std::cos(bearing), std::sin(bearing), 0.0))
              .cast<float>();
      const Eigen::Vector3f origin = sensor.translation().cast<float>();
      const auto hit = world.cast(origin, way, static_cast<float>(info->second.range_max_m));
      if (hit) beams.ends.push_back({origin + hit->range_m * way, hit->normal, hit->triangle});
    }
  }
  return beams;
}

}  // namespace marco
