#include "simulator/batch_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"

namespace marco::sim {
namespace {

double draw_sign(std::mt19937_64& random) {
  return std::uniform_real_distribution<double>(-1.0, 1.0)(random) < 0.0 ? -1.0 : 1.0;
}

double draw_slip_m(const OdometryOptions& options, std::mt19937_64& random) {
  if (options.slip_every_m <= 0.0) return std::numeric_limits<double>::infinity();
  return std::exponential_distribution<double>(1.0 / options.slip_every_m)(random);
}

// A smooth floor that is level almost nowhere: roll and pitch as -1..1 of their limit.
Eigen::Vector2d floor_slope(const Eigen::Vector2d& at) {
  return {
      0.6 * std::sin(1.7 * at.x() + 0.4 * at.y()) + 0.4 * std::sin(0.9 * at.y() - 2.3 * at.x()),
      0.6 * std::sin(1.3 * at.y() - 0.7 * at.x()) + 0.4 * std::sin(2.1 * at.x() + 1.1 * at.y())};
}

OdometryOptions errors_of(const SimulationOptions& options) {
  const std::string& told = options.robot.odometry;
  require(told == "wheels" || told == "gyro" || told == "still" || told == "none",
          "robot.odometry '" + told + "': expected wheels, gyro, still or none");
  OdometryOptions errors = options.odometry;
  if (told == "gyro") errors.drift_deg_per_m = errors.slip_every_m = 0.0;
  return errors;
}

bool sweeps(const Tour& tour) {
  return std::any_of(tour.steps.begin(), tour.steps.end(), [](const TourStep& step) {
    return step.kind == "sweep" || step.kind == "pan";
  });
}

}  // namespace

OdometryModel::OdometryModel(const OdometryOptions& options,
                             const Pose2& world_from_robot,
                             std::mt19937_64& random)
    : options_(options),
      distance_scale_(1.0 + draw_sign(random) * options.distance_error),
      turn_scale_(1.0 + draw_sign(random) * options.turn_error),
      drift_rad_per_m_(draw_sign(random) * deg_to_rad(options.drift_deg_per_m)),
      to_next_slip_m_(draw_slip_m(options, random)),
      world_from_robot_(world_from_robot) {
  validate(options, "odometry");
}

const Pose2& OdometryModel::move_to(const Pose2& world_from_robot, std::mt19937_64& random) {
  const Pose2 step = between(world_from_robot_, world_from_robot);
  world_from_robot_ = world_from_robot;
  const double distance_m = step.translation_m().norm();
  odom_from_robot_ =
      odom_from_robot_ * Pose2{distance_scale_ * step.x_m, distance_scale_ * step.y_m,
                               turn_scale_ * step.theta_rad + drift_rad_per_m_ * distance_m};
  to_next_slip_m_ -= distance_m;
  if (to_next_slip_m_ <= 0.0) {
    odom_from_robot_ =
        odom_from_robot_ *
        Pose2{options_.slip_m, 0.0, draw_sign(random) * deg_to_rad(options_.slip_turn_deg)};
    to_next_slip_m_ = draw_slip_m(options_, random);
  }
  return odom_from_robot_;
}

LoggerModel::LoggerModel(const LoggerOptions& options, const LaserOptions& laser)
    : options_(options), laser_(laser), beam_times_(named(options.beam_times)) {
  validate(options, "logger");
}

LoggerModel::BeamTimes LoggerModel::named(const std::string& name) {
  if (name == "right") return BeamTimes::right;
  if (name == "milliseconds") return BeamTimes::milliseconds;
  if (name == "reversed") return BeamTimes::reversed;
  if (name == "equal") return BeamTimes::equal;
  require(name == "missing", "logger.beam_times '" + name +
                                 "': expected right, milliseconds, reversed, equal or missing");
  return BeamTimes::missing;
}

double LoggerModel::measured_s(double said_s) const {
  return beam_times_ == BeamTimes::reversed ? laser_.scan_duration_s - said_s : said_s;
}

double LoggerModel::told_duration_s() const {
  return beam_times_ == BeamTimes::right ? laser_.scan_duration_s : 0.0;
}

std::optional<Utime> LoggerModel::stamp(Utime start, double began_s, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 1.0);
  if (options_.dropped_scans > 0.0 && uniform(random) < options_.dropped_scans) return {};
  Utime stamp = start + Duration::from_seconds((1.0 + options_.clock_drift) * began_s +
                                               options_.stamp_late_s);
  if (options_.stamp_jitter_s > 0.0) {
    stamp = stamp + Duration::from_seconds(options_.stamp_jitter_s * noise(random));
  }
  if (options_.burst_part > 0.0 && uniform(random) < options_.burst_part) {
    stamp = last_stamp_.value_or(start) + Duration::from_us(1000);
  }
  last_stamp_ = stamp;
  return stamp;
}

float LoggerModel::told_offset_s(int beam) const {
  constexpr double kMicrosecondsInAMillisecond = 1000.0;
  const double offset_s = (1.0 + options_.clock_drift) * laser_.time_of_beam_s(beam);
  if (beam_times_ == BeamTimes::equal) return 0.0F;
  if (beam_times_ == BeamTimes::milliseconds) {
    return static_cast<float>(offset_s / kMicrosecondsInAMillisecond);
  }
  return static_cast<float>(offset_s);
}

std::vector<LaserScan> LoggerModel::messages(const LaserScan& scan) const {
  if (beam_times_ == BeamTimes::missing) return {scan};
  LaserScan raw = scan;
  raw.channel = channels::kLidarRaw;
  for (int beam = 0; beam < laser_.beams; ++beam) raw.time_offsets_s.push_back(told_offset_s(beam));
  if (beam_times_ == BeamTimes::right) return {raw, scan};
  return {raw};
}

BatchSimulation::BatchSimulation(const RayCaster& rays,
                                 const Tour& tour,
                                 const SimulationOptions& options,
                                 uint64_t seed)
    : options_(options),
      plan_(tour, options.robot, options.laser.scans_per_s),
      laser_(rays, options.laser),
      random_(seed),
      odometry_(errors_of(options), plan_.at(0.0).world_from_robot, random_),
      logger_(options.logger, options.laser) {
  validate(options, "simulation");
  require(has_pantilt() || !sweeps(tour),
          "steps: a sweep, but robot.pantilt_state_hz is 0: no pan-tilt");
  base_info_.channel = channels::kPanTiltState;
  base_info_.parent_from_sensor =
      make_pose3({options.robot.pantilt_ahead_m, 0.0, options.robot.tilt_axis_height_m});
  laser_info_.channel = channels::kLidar;
  laser_info_.mount = SensorInfo::Mount::pantilt;
  const std::vector<double>& rpy_deg = options.robot.laser_roll_pitch_yaw_deg;
  require(rpy_deg.size() == 3, "robot.laser_roll_pitch_yaw_deg: expected three numbers");
  laser_info_.parent_from_sensor =
      make_pose3({options.robot.laser_ahead_m, 0.0, options.robot.laser_above_m},
                 deg_to_rad(rpy_deg[0]), deg_to_rad(rpy_deg[1]), deg_to_rad(rpy_deg[2]));
  if (!has_pantilt()) {
    laser_info_.mount = SensorInfo::Mount::robot;
    laser_info_.parent_from_sensor = base_info_.parent_from_sensor * laser_info_.parent_from_sensor;
  }
  laser_info_.scan_duration_s = logger_.told_duration_s();
  laser_info_.range_min_m = options.laser.range_min_m;
  // Rounded as the ranges are: a "no return" must not lie a rounding error below the limit.
  laser_info_.range_max_m = static_cast<double>(static_cast<float>(options.laser.range_max_m));
  laser_info_.range_sigma_m = options.laser.range_sigma_m;
  const std::vector<double>& level_m = options.robot.level_laser_m;
  if (level_m.empty()) return;
  require(level_m.size() == 3, "robot.level_laser_m: expected three numbers");
  level_info_ = laser_info_;
  level_info_->channel = std::string(channels::kLidar) + "_LEVEL";
  level_info_->mount = SensorInfo::Mount::robot;
  level_info_->parent_from_sensor = make_pose3({level_m[0], level_m[1], level_m[2]});
}

Pose3 BatchSimulation::world_from_robot(double seconds) const {
  const RobotState state = plan_.at(seconds);
  const Eigen::Vector2d slope = deg_to_rad(options_.odometry.floor_tilt_deg) *
                                floor_slope(state.world_from_robot.translation_m());
  return lift(state.world_from_robot) *
         make_pose3(Eigen::Vector3d::Zero(), slope.x(), slope.y(), 0.0);
}

Pose3 BatchSimulation::world_from_laser(double seconds) const {
  const RobotState state = plan_.at(seconds);
  return world_from_robot(seconds) *
         (has_pantilt()
              ? robot_from_pantilt_sensor(base_info_, laser_info_, state.pan_rad, state.tilt_rad)
              : laser_info_.parent_from_sensor);
}

void BatchSimulation::send(const Sample& sample, double seconds) {
  sent_(sample, utime_at(seconds));
}

void BatchSimulation::send_infos(double seconds) {
  for (SensorInfo* info : {&base_info_, &laser_info_, level_info_ ? &*level_info_ : nullptr}) {
    if (info == nullptr || (info == &base_info_ && !has_pantilt())) continue;
    info->utime = utime_at(seconds);
    send(*info, seconds);
  }
}

void BatchSimulation::send_odometry(double seconds) {
  const std::string& told = options_.robot.odometry;
  if (told == "none") return;
  OdometrySample sample;
  sample.utime = utime_at(seconds);
  const Pose2 measured = odometry_.move_to(plan_.at(seconds).world_from_robot, random_);
  if (told == "wheels") sample.odom_from_robot = measured;
  if (told == "gyro") sample.odom_from_robot.theta_rad = measured.theta_rad;
  send(sample, seconds);
}

void BatchSimulation::send_pantilt(double seconds) {
  if (!has_pantilt()) return;
  const RobotState state = plan_.at(seconds);
  PanTiltState sample;
  sample.utime = utime_at(seconds);
  sample.pan_rad = state.pan_rad;
  sample.tilt_rad = state.tilt_rad;
  send(sample, seconds);
}

void BatchSimulation::send_scan(double first_beam_s) {
  LaserScan scan;
  const auto moment = [&](double said_s) -> LaserMoment {
    const double seconds = first_beam_s + logger_.measured_s(said_s);
    return {world_from_laser(seconds), seconds};
  };
  scan.ranges_m = laser_.scan(moment, random_);
  const std::optional<Utime> stamp = logger_.stamp(kStart, first_beam_s, random_);
  if (!stamp) return;
  scan.utime = *stamp;
  scan.first_bearing_rad = deg_to_rad(options_.laser.first_bearing_deg);
  scan.bearing_step_rad = deg_to_rad(options_.laser.step_deg);
  const double sent_s = first_beam_s + options_.laser.scan_duration_s;
  send(TruePose{scan.utime, plan_.at(first_beam_s).world_from_robot}, sent_s);
  for (const LaserScan& message : logger_.messages(scan)) send(message, sent_s);
}

void BatchSimulation::send_level_scan(double first_beam_s) {
  LaserScan scan;
  scan.channel = level_info_->channel;
  scan.utime = utime_at(first_beam_s);
  scan.first_bearing_rad = deg_to_rad(options_.laser.first_bearing_deg);
  scan.bearing_step_rad = deg_to_rad(options_.laser.step_deg);
  scan.ranges_m = laser_.scan(
      [&](double after_s) -> LaserMoment {
        const double seconds = first_beam_s + after_s;
        return {world_from_robot(seconds) * level_info_->parent_from_sensor, seconds};
      },
      random_);
  const double sent_s = first_beam_s + options_.laser.scan_duration_s;
  send(TruePose{scan.utime, plan_.at(first_beam_s).world_from_robot}, sent_s);
  send(scan, sent_s);
}

void BatchSimulation::run(const std::function<void(const Sample&, Utime)>& sent,
                          const std::function<void(double)>& progress) {
  sent_ = sent;
  // Each source sends at its own period, a scan after its last beam. The source due first is next.
  // The second laser turns by half a period later.
  enum Source { info, odometry, pantilt, scan, level_scan, sources };
  const double scan_period_s = 1.0 / options_.laser.scans_per_s;
  const double periods_s[sources] = {1.0, 1.0 / options_.odometry.rate_hz,
                                     has_pantilt() ? 1.0 / options_.robot.pantilt_state_hz : 1.0,
                                     scan_period_s, scan_period_s};
  const double lasts_s = options_.laser.scan_duration_s;
  const double delays_s[sources] = {0.0, 0.0, 0.0, lasts_s, 0.5 * scan_period_s + lasts_s};
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
      send_odometry(now_s);
    } else if (next == pantilt) {
      send_pantilt(now_s);
    } else if (next == scan) {
      send_scan(now_s - lasts_s);
    } else if (level_info_) {
      send_level_scan(now_s - lasts_s);
    }
  }
}

}  // namespace marco::sim
