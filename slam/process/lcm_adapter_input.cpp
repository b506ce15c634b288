// What a SlamAdapter makes of a scan and of what else is known at its time.
#include <cmath>

#include "lcmtypes/channels.hpp"
#include "slam/process/lcm_adapter.hpp"

namespace marco::slam {
namespace {

// A scan that takes so long is straightened by what odometry says. The last match's velocity would
// feed back: a scan turned by a wrong velocity is matched as wrong the other way, and worse from
// scan to scan.
constexpr double kLongScanS = 0.05;

}  // namespace

bool SlamAdapter::is_level(const Pose2& first_beam, const Pose2& last_beam) const {
  const double limit_rad = deg_to_rad(options_.level_tilt_limit_deg);
  const double panned_rad = normalize_angle(last_beam.x_m - first_beam.x_m);
  return std::abs(first_beam.y_m) <= limit_rad && std::abs(last_beam.y_m) <= limit_rad &&
         std::abs(panned_rad) <= deg_to_rad(options_.pan_in_scan_limit_deg);
}

Velocity2 SlamAdapter::velocity_during(const LaserScan& scan, double duration_s) const {
  if (!scan.time_offsets_s.empty()) duration_s = scan.time_offsets_s.back();
  if (duration_s < kLongScanS) return session_.velocity();
  const auto moved = motion_.odometry.motion_during(scan.utime, Duration::from_seconds(duration_s));
  const auto velocity =
      moved ? believed_velocity(*moved, duration_s, options_.slam.motion) : std::nullopt;
  return velocity.value_or(session_.velocity());
}

SlamInput SlamAdapter::input_of(const LaserScan& scan, const SensorInfo& info) const {
  SlamInput input;
  const Duration reach = Duration::from_seconds(options_.patience_s);
  input.motion.utime = scan.utime;
  input.motion.odom_from_robot = motion_.odometry.at(scan.utime, reach);
  if (const auto heading = motion_.gyro_heading.at(scan.utime, reach)) {
    input.motion.gyro_heading_rad = heading->theta_rad;
  }
  Pose3 robot_from_sensor = info.parent_from_sensor;
  if (info.mount == SensorInfo::Mount::pantilt) {
    const auto base = sensors_.find(channels::kPanTiltState);
    const auto angles = motion_.pantilt.at(scan.utime, reach);
    const auto angles_at_end =
        motion_.pantilt.at(scan.utime + Duration::from_seconds(info.scan_duration_s), reach);
    if (base != sensors_.end() && angles) {
      robot_from_sensor = robot_from_pantilt_sensor(base->second, info, angles->x_m, angles->y_m);
      input.level = is_level(*angles, angles_at_end.value_or(*angles));
    }
  }
  input.scan = deskew_and_project(scan, info, robot_from_sensor,
                                  velocity_during(scan, info.scan_duration_s));
  return input;
}

}  // namespace marco::slam
