#include "common/input/sensor_synchronizer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco {
namespace {

// Scans: more than patience_s lets wait at any rate of a laser, so only stamps far ahead fill it.
constexpr std::size_t kMostWaiting = 200;

// Odometry that was looked up by a stalled logger's stamps is known when the stall is over.
constexpr double kStallS = 2.0;

}  // namespace

std::optional<double> integrated_heading_rad(const StampedPose2& last, const ImuSample& sample) {
  constexpr double kMaxGapS = 0.5;  // across a longer gap the rate is not known
  const double dt_s = (sample.utime - last.utime).seconds();
  if (dt_s < 0.0 || dt_s > kMaxGapS) return std::nullopt;
  const double turned_rad = dt_s * sample.angular_velocity_rad_per_s.z();
  return normalize_angle(last.world_from_robot.theta_rad + turned_rad);
}

double duration_of(const LaserScan& scan, const SensorInfo& info) {
  constexpr double kLongestS = 10.0;  // damaged messages must not stretch a scan without end
  if (scan.time_offsets_s.empty()) return info.scan_duration_s;
  const auto last = std::max_element(scan.time_offsets_s.begin(), scan.time_offsets_s.end());
  return std::clamp(static_cast<double>(*last), 0.0, kLongestS);
}

SensorSynchronizer::SensorSynchronizer(const SynchronizerOptions& options,
                                       ChannelNames names,
                                       CountDrop drop)
    : options_(options),
      names_(std::move(names)),
      drop_(drop ? std::move(drop) : [](const std::string&) {}) {
  validate(options, "input");
  restore({});
}

void SensorSynchronizer::restore(SynchronizerState state) {
  state_ = std::move(state);
  state_.pantilt.set_limits(Duration::from_seconds(options_.pantilt_gap_s),
                            Duration::from_seconds(options_.pantilt_reach_s));
}

void SensorSynchronizer::start_session() {
  complete_all();
  restore({});
}

const SensorInfo* SensorSynchronizer::sensor_of(const std::string& channel) const {
  const SensorInfo* own = find_sensor(state_.sensors, channel);
  return own != nullptr ? own : find_sensor(state_.sensors, names_.lidar_of(channel));
}

void SensorSynchronizer::add(const SensorInfo& info) {
  require(note_sensor(state_.sensors, options_.calibration.laser.corrected(info)), kTooManySensors);
}

void SensorSynchronizer::add(const OdometrySample& raw) {
  if (const auto wrong = odometry_units_.look(raw)) {
    state_.odometry.clear();
    state_.odometry_restarted = true;
    return drop_(*wrong);
  }
  const OdometrySample sample =
      state_.odometry_corrector.corrected(raw, options_.calibration.odometry);
  if (state_.odometry.restarts_at(sample)) {
    drop_("odometry restarted: ignored for one scan");
    // What waits was measured before.
    complete_all();
    state_.odometry.clear();
    state_.odometry_restarted = true;
  }
  state_.odometry.add(sample);
  for (WaitingScan& waiting : state_.waiting) {
    if (waiting.scan.utime == sample.utime) waiting.own_odometry = sample.odom_from_robot;
  }
  advance();
}

void SensorSynchronizer::add(const ImuSample& raw) {
  const ImuSample sample = options_.calibration.gyro.corrected(raw);
  PoseBuffer& heading = state_.gyro_heading;
  double heading_rad = 0.0;
  if (!heading.empty()) {
    const StampedPose2 last{heading.newest(), heading.newest_pose()};
    const auto turned_rad = integrated_heading_rad(last, sample);
    heading_rad = turned_rad.value_or(last.world_from_robot.theta_rad);
    if (!turned_rad) {
      drop_("imu: gap in time");
      heading.clear();
    }
  }
  heading.add(sample.utime, {0.0, 0.0, heading_rad});
}

void SensorSynchronizer::add(PanTiltState state) {
  state.utime = state.utime - Duration::from_seconds(options_.pantilt_late_s);
  if (!state_.pantilt.add(state)) drop_("pan-tilt stamp steps back");
  advance();
}

void SensorSynchronizer::add(LaserScan scan) {
  const RuleContext context{sensor_of(scan.channel), names_.lidar_of(scan.channel),
                            options_.calibration, drop_};
  WaitingScan waiting;
  waiting.own_odometry = state_.odometry.own_of(scan.utime);
  waiting.scan = std::move(scan);
  if (!state_.rules.apply(waiting, context)) return;
  state_.newest = waiting.repaired;
  state_.waiting.push_back(std::move(waiting));
  advance();
}

std::optional<BeamOrder> SensorSynchronizer::note_misfits(const SynchronizedScan& scan,
                                                          const std::vector<double>& misfits_m2) {
  if (misfits_m2.empty()) return std::nullopt;
  BeamOrderJudge& judge = state_.rules.get<scan_rules::BeamsOrdered>().judges[scan.scan.channel];
  if (!judge.note(scan.beam_order, misfits_m2)) return std::nullopt;
  drop_(scan.scan.channel + ": " + judge.description());
  return judge.present();
}

void SensorSynchronizer::advance() {
  while (!state_.waiting.empty() &&
         (state_.waiting.size() > kMostWaiting || is_complete(state_.waiting.front()))) {
    complete_first();
  }
}

bool SensorSynchronizer::is_complete(const WaitingScan& waiting) const {
  const double patience_s = options_.patience_s + (state_.odometry.is_looked_up() ? kStallS : 0.0);
  if (std::abs((state_.newest - waiting.repaired).seconds()) > patience_s) return true;
  const SensorInfo* info = sensor_of(waiting.scan.channel);
  const double duration_s = duration_of(waiting.scan, *info);
  if (!state_.odometry.covers(waiting.at(), duration_s, patience_s)) return false;
  if (info->mount != SensorInfo::Mount::pantilt) return true;
  const Utime last_beam = waiting.repaired + Duration::from_seconds(duration_s);
  if (state_.pantilt.empty()) return state_.pantilt_is_silent;
  return state_.pantilt.reaches(last_beam) ||
         (last_beam - state_.pantilt.newest().utime).seconds() > patience_s;
}

void SensorSynchronizer::complete_all() {
  while (!state_.waiting.empty()) complete_first();
}

void SensorSynchronizer::complete_first() {
  WaitingScan first = std::move(state_.waiting.front());
  state_.waiting.pop_front();
  complete_.push_back(synchronized(std::move(first)));
}

std::optional<SynchronizedScan> SensorSynchronizer::next() {
  if (complete_.empty()) return std::nullopt;
  SynchronizedScan oldest = std::move(complete_.front());
  complete_.pop_front();
  return oldest;
}

SynchronizedScan SensorSynchronizer::synchronized(WaitingScan waiting) {
  const OdometryTrack::AtScan at = waiting.at();
  SynchronizedScan result;
  result.info = *sensor_of(waiting.scan.channel);
  result.duration_s = duration_of(waiting.scan, result.info);
  result.motion.utime = at.repaired;
  result.motion.scan_period_s = at.period_s;
  result.motion.off_beat = waiting.off_beat;
  result.motion.odom_from_robot = state_.odometry.at(at, options_.patience_s);
  result.odometry_step = state_.odometry.motion_during(at, result.duration_s);
  state_.odometry.note(at);
  // What was counted before a restart and after it is not compared.
  if (std::exchange(state_.odometry_restarted, false)) result.motion.odom_from_robot.reset();
  const Duration reach = Duration::from_seconds(options_.patience_s);
  if (const auto heading = state_.gyro_heading.at(at.repaired, reach)) {
    result.motion.gyro_heading_rad = heading->theta_rad;
  }
  result.robot_from_sensor = result.info.parent_from_sensor;
  result.level = !is_steep(result.robot_from_sensor);
  if (result.info.mount == SensorInfo::Mount::pantilt) {
    state_.pantilt_is_silent = state_.pantilt.empty();
    look_up_pantilt(result);
  }
  result.beam_order = std::move(waiting.beam_order);
  result.scan = std::move(waiting.scan);
  return result;
}

// With a level laser that sends scans, a nodding laser is used for 3D only.
bool SensorSynchronizer::has_level_laser() const {
  const auto& lasers = rules().get<scan_rules::StampRepaired>().lasers;
  return std::any_of(lasers.begin(), lasers.end(), [this](const auto& laser) {
    const SensorInfo* info = sensor_of(laser.first);
    return info != nullptr && info->mount == SensorInfo::Mount::robot &&
           !is_steep(info->parent_from_sensor);
  });
}

void SensorSynchronizer::look_up_pantilt(SynchronizedScan& scan) const {
  const SensorInfo* base = pantilt_base();
  if (base != nullptr) {
    scan.robot_from_sensor = robot_from_pantilt_sensor(*base, scan.info, 0.0, 0.0);
  }
  scan.level = !has_level_laser() && !is_steep(scan.robot_from_sensor);
  if (base == nullptr || state_.pantilt.empty()) return;
  const Utime first_beam = scan.motion.utime;
  const auto first = state_.pantilt.at(first_beam);
  const auto last = state_.pantilt.at(first_beam + Duration::from_seconds(scan.duration_s));
  scan.angles_known = first && last;
  // A pan-tilt that has fallen silent is taken to stand where it was.
  const PanTiltState& newest = state_.pantilt.newest();
  scan.first_angles = first.value_or(newest.angles());
  scan.last_angles = last.value_or(scan.first_angles);
  const auto place_at = [&](const PanTiltAngles& angles) {
    return *robot_from_sensor(scan.info, base, angles);
  };
  scan.robot_from_sensor = place_at(scan.first_angles);
  const double limit_cosine = std::cos(deg_to_rad(options_.level_tilt_limit_deg));
  const auto lies_level = [&](const PanTiltAngles& angles) {
    return std::abs(place_at(angles).linear()(2, 2)) >= limit_cosine - 1e-12;
  };
  const double panned_rad = normalize_angle(scan.last_angles.pan_rad - scan.first_angles.pan_rad);
  scan.level = !has_level_laser() && lies_level(scan.first_angles) &&
               lies_level(scan.last_angles) &&
               std::abs(panned_rad) <= deg_to_rad(options_.pan_in_scan_limit_deg);
}

}  // namespace marco
