#include "common/input/sensor_synchronizer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/input/beam_times.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco {
namespace {

// Scans: more than patience_s lets wait at any rate of a laser, so only stamps far ahead fill it.
constexpr std::size_t kMostWaiting = 200;

// Odometry that was looked up by a stalled logger's stamps is known when the stall is over.
constexpr double kStallS = 2.0;

}  // namespace

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
      drop_(drop ? std::move(drop) : [](const std::string&) {}),
      lidars_(names_.lidar_of) {
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
  lidars_.clear();
  rates_.clear();
  reported_channels_.clear();
}

const SensorInfo* SensorSynchronizer::sensor_of(const std::string& channel) const {
  auto found = state_.sensors.find(channel);
  if (found == state_.sensors.end()) found = state_.sensors.find(names_.lidar_of(channel));
  return found == state_.sensors.end() ? nullptr : &found->second;
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
    constexpr double kMaxGapS = 0.5;  // across a longer gap the rate is not known
    const double dt_s = (sample.utime - heading.newest()).seconds();
    heading_rad = heading.newest_pose().theta_rad;
    if (dt_s < 0.0 || dt_s > kMaxGapS) {
      drop_("imu: gap in time");
      heading.clear();
    } else {
      heading_rad = normalize_angle(heading_rad + dt_s * sample.angular_velocity_rad_per_s.z());
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
  if (sensor_of(scan.channel) == nullptr) {
    return drop_("no SENSOR_INFO for " + scan.channel + " yet");
  }
  if (lidars_.came_before(scan)) return drop_("duplicate scan");
  if (!lidars_.is_used(scan)) return;
  if (rates_.is_new_sender(scan.channel, scan.utime)) drop_(rates_.notice());
  if (const auto wrong = range_units_.look(scan)) return drop_(*wrong);
  correct_beams(scan);
  blank_body_and_floor(scan);
  StampRepair& stamps = state_.stamps[scan.channel];
  WaitingScan waiting;
  waiting.repaired = stamps.repair(scan.utime);
  waiting.period_s = stamps.period_s();
  waiting.off_beat = stamps.off_beat();
  waiting.own_odometry = state_.odometry.own_of(scan.utime);
  waiting.beam_order = repair_beams(scan, waiting.period_s);
  waiting.scan = std::move(scan);
  state_.newest = waiting.repaired;
  state_.waiting.push_back(std::move(waiting));
  advance();
}

void SensorSynchronizer::correct_beams(LaserScan& scan) const {
  const double range_max_m = sensor_of(scan.channel)->range_max_m;
  for (const BeamCalibration& beams : options_.calibration.beams) {
    if (beams.channel == scan.channel) beams.correct(scan, range_max_m);
  }
}

// On a pan-tilt the robot is elsewhere in every scan.
void SensorSynchronizer::blank_body_and_floor(LaserScan& scan) {
  for (const BodyPart& part : options_.calibration.body) {
    if (part.channel == scan.channel) blank(scan, part);
  }
  for (const FloorLine& floor : options_.calibration.floor) {
    if (floor.channel == scan.channel) blank(scan, floor);
  }
  if (sensor_of(scan.channel)->mount != SensorInfo::Mount::robot) return;
  OwnBody& body = state_.own_bodies[scan.channel];
  const bool was_known = !body.parts().empty();
  if (body.look(scan) && !was_known && !body.parts().empty()) {
    drop_(describe(body.parts()) + ": these returns are ignored");
  }
  for (const BodyPart& part : body.parts()) blank(scan, part);
}

BeamVerdict SensorSynchronizer::repair_beams(LaserScan& scan, double period_s) {
  const auto wrong = repair_beam_times(scan, period_s);
  if (wrong && reported_channels_.insert(scan.channel).second) drop_(scan.channel + ": " + *wrong);
  // A laser that gives the duration of its scan gives the times of its beams.
  if (scan.time_offsets_s.empty() && is_turn_period(sensor_of(scan.channel)->scan_duration_s)) {
    return {};
  }
  return state_.beam_orders[scan.channel].look(scan, period_s);
}

std::optional<BeamOrder> SensorSynchronizer::note_misfits(const SynchronizedScan& scan,
                                                          const std::vector<double>& misfits_m2) {
  if (misfits_m2.empty()) return std::nullopt;
  BeamOrderJudge& judge = state_.beam_orders[scan.scan.channel];
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
  return std::any_of(state_.stamps.begin(), state_.stamps.end(), [this](const auto& laser) {
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
  scan.first_angles = first.value_or(PanTiltAngles{newest.pan_rad, newest.tilt_rad});
  scan.last_angles = last.value_or(scan.first_angles);
  const auto robot_from_sensor = [&](const PanTiltAngles& angles) {
    return robot_from_pantilt_sensor(*base, scan.info, angles.pan_rad, angles.tilt_rad);
  };
  scan.robot_from_sensor = robot_from_sensor(scan.first_angles);
  const double limit_cosine = std::cos(deg_to_rad(options_.level_tilt_limit_deg));
  const auto lies_level = [&](const PanTiltAngles& angles) {
    return std::abs(robot_from_sensor(angles).linear()(2, 2)) >= limit_cosine - 1e-12;
  };
  const double panned_rad = normalize_angle(scan.last_angles.pan_rad - scan.first_angles.pan_rad);
  scan.level = !has_level_laser() && lies_level(scan.first_angles) &&
               lies_level(scan.last_angles) &&
               std::abs(panned_rad) <= deg_to_rad(options_.pan_in_scan_limit_deg);
}

}  // namespace marco
