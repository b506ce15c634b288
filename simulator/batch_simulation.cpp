#include "simulator/batch_simulation.hpp"

#include <algorithm>
#include <cmath>

#include "lcmtypes/channels.hpp"

namespace marco::sim {
namespace {

// A smooth floor that is level almost nowhere: roll and pitch as -1..1 of their limit.
Eigen::Vector2d floor_slope(const Eigen::Vector2d& at) {
  return {
      0.6 * std::sin(1.7 * at.x() + 0.4 * at.y()) + 0.4 * std::sin(0.9 * at.y() - 2.3 * at.x()),
      0.6 * std::sin(1.3 * at.y() - 0.7 * at.x()) + 0.4 * std::sin(2.1 * at.x() + 1.1 * at.y())};
}

}  // namespace

BatchSimulation::BatchSimulation(const RayCaster& rays,
                                 const Tour& tour,
                                 const SimulationOptions& options,
                                 uint64_t seed)
    : options_(options),
      plan_(tour, options.robot, options.laser.scans_per_s),
      laser_(rays, options.laser),
      random_(seed),
      odometry_(options.odometry, plan_.at(0.0).world_from_robot, random_) {
  validate(options, "simulation");
  base_info_.channel = channels::kPanTiltState;
  base_info_.parent_from_sensor =
      make_pose3({options.robot.pantilt_ahead_m, 0.0, options.robot.tilt_axis_height_m});
  laser_info_.channel = channels::kLidar;
  laser_info_.mount = SensorInfo::Mount::pantilt;
  laser_info_.parent_from_sensor =
      make_pose3({options.robot.laser_ahead_m, 0.0, options.robot.laser_above_m});
  laser_info_.scan_duration_s = options.laser.scan_duration_s;
  laser_info_.range_min_m = options.laser.range_min_m;
  // Rounded as the ranges are: a "no return" must not lie a rounding error below the limit.
  laser_info_.range_max_m = static_cast<double>(static_cast<float>(options.laser.range_max_m));
  laser_info_.range_sigma_m = options.laser.range_sigma_m;
}

Pose3 BatchSimulation::world_from_laser(double seconds) const {
  const RobotState state = plan_.at(seconds);
  const Eigen::Vector2d slope = deg_to_rad(options_.odometry.floor_tilt_deg) *
                                floor_slope(state.world_from_robot.translation_m());
  return lift(state.world_from_robot) *
         make_pose3(Eigen::Vector3d::Zero(), slope.x(), slope.y(), 0.0) *
         robot_from_pantilt_sensor(base_info_, laser_info_, state.pan_rad, state.tilt_rad);
}

void BatchSimulation::send(const Sample& sample, double seconds) {
  sent_(sample, utime_at(seconds));
}

void BatchSimulation::send_infos(double seconds) {
  for (SensorInfo* info : {&base_info_, &laser_info_}) {
    info->utime = utime_at(seconds);
    send(*info, seconds);
  }
}

void BatchSimulation::send_scan(double first_beam_s) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 1.0);
  LaserScan scan;
  scan.ranges_m = laser_.scan(
      [&](double after_s) { return world_from_laser(first_beam_s + after_s); }, random_);
  const LoggerOptions& logger = options_.logger;
  if (logger.dropped_scans > 0.0 && uniform(random_) < logger.dropped_scans) return;
  scan.utime = utime_at(first_beam_s);
  if (logger.stamp_jitter_s > 0.0) {
    scan.utime = scan.utime + Duration::from_seconds(logger.stamp_jitter_s * noise(random_));
  }
  if (logger.burst_part > 0.0 && uniform(random_) < logger.burst_part) {
    scan.utime = last_stamp_ + Duration::from_us(1000);
  }
  last_stamp_ = scan.utime;
  scan.first_bearing_rad = deg_to_rad(options_.laser.first_bearing_deg);
  scan.bearing_step_rad = deg_to_rad(options_.laser.step_deg);
  const double sent_s = first_beam_s + options_.laser.scan_duration_s;
  send(TruePose{scan.utime, plan_.at(first_beam_s).world_from_robot}, sent_s);
  LaserScan raw = scan;
  raw.channel = channels::kLidarRaw;
  for (int beam = 0; beam < options_.laser.beams; ++beam) {
    raw.time_offsets_s.push_back(static_cast<float>(options_.laser.time_of_beam_s(beam)));
  }
  send(raw, sent_s);
  send(scan, sent_s);
}

void BatchSimulation::run(const std::function<void(const Sample&, Utime)>& sent,
                          const std::function<void(double)>& progress) {
  sent_ = sent;
  last_stamp_ = kStart;
  // Each source sends at its own period, a scan after its last beam. The source due first is next.
  enum Source { info, odometry, pantilt, scan, sources };
  const double periods_s[sources] = {1.0, 1.0 / options_.odometry.rate_hz,
                                     1.0 / options_.robot.pantilt_state_hz,
                                     1.0 / options_.laser.scans_per_s};
  const double delays_s[sources] = {0.0, 0.0, 0.0, options_.laser.scan_duration_s};
  int64_t counts[sources] = {};
  const auto due_s = [&](int source) {
    return static_cast<double>(counts[source]) * periods_s[source] + delays_s[source];
  };
  while (true) {
    int next = info;
    for (int source = 0; source < sources; ++source) {
      if (due_s(source) < due_s(next)) next = source;
    }
    const double now_s = due_s(next);
    if (now_s > duration_s()) break;
    ++counts[next];
    if (next == info) {
      send_infos(now_s);
      if (progress) progress(now_s / duration_s());
    } else if (next == odometry) {
      OdometrySample sample;
      sample.utime = utime_at(now_s);
      sample.odom_from_robot = odometry_.move_to(plan_.at(now_s).world_from_robot, random_);
      send(sample, now_s);
    } else if (next == pantilt) {
      const RobotState state = plan_.at(now_s);
      PanTiltState sample;
      sample.utime = utime_at(now_s);
      sample.pan_rad = state.pan_rad;
      sample.tilt_rad = state.tilt_rad;
      send(sample, now_s);
    } else {
      send_scan(now_s - delays_s[scan]);
    }
  }
}

}  // namespace marco::sim
