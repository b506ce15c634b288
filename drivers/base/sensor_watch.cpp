#include "drivers/base/sensor_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lcm_tools/base/format.hpp"

namespace marco::drivers {
namespace {

constexpr std::size_t kMostSensors = 16;
constexpr double kDisputeS = 10.0;
constexpr double kRecentS = 1.5;
constexpr double kLevelDeg = 3.0;
constexpr const char* kPanTilt = "PANTILT_STATE";

bool differs(const SensorInfo& a, const SensorInfo& b) {
  constexpr double kM = 0.001, kDeg = 0.1;
  const Pose3 step = a.parent_from_sensor.inverse() * b.parent_from_sensor;
  return a.mount != b.mount || step.translation().norm() > kM ||
         Eigen::AngleAxisd(step.linear()).angle() > deg_to_rad(kDeg) ||
         (a.tilt_axis_m - b.tilt_axis_m).norm() > kM ||
         std::abs(a.range_min_m - b.range_min_m) > kM ||
         std::abs(a.range_max_m - b.range_max_m) > kM;
}

bool is_level(const Pose3& robot_from_laser) {
  return std::abs(robot_from_laser.linear()(2, 2)) > std::cos(deg_to_rad(kLevelDeg));
}

/// How long a sensor's readings may fail to come.
double patience_s(double interval_s) { return std::max(0.5, std::min(3.0 * interval_s, 1.5)); }

}  // namespace

SensorWatch::Sensor* SensorWatch::known_or_new(const std::string& name) {
  if (sensors_.size() >= kMostSensors && !sensors_.contains(name)) return nullptr;
  return &sensors_[name];
}

void SensorWatch::on_info(const SensorInfo& info, Utime now) {
  if (!info.channel.starts_with("LIDAR") && info.channel != kPanTilt) return;
  Sensor* sensor = known_or_new(info.channel);
  if (sensor == nullptr) return;
  if (!sensor->info) sensor->info = info;
  if (differs(*sensor->info, info)) sensor->refused = now;
}

void SensorWatch::on_pantilt(const PanTiltState& state, Utime now) {
  pantilt_ = state;
  pantilt_came_ = now;
}

bool SensorWatch::on_reading(const std::string& name, Utime stamp, Utime now) {
  Sensor* sensor = known_or_new(name);
  if (sensor == nullptr || std::exchange(sensor->stamp, stamp) == stamp) return false;
  const double since_s = (now - std::exchange(sensor->read, now)).seconds();
  if (since_s > 0.0 && since_s < 2.0) {  // else it was away
    constexpr double kNew = 0.2;
    sensor->interval_s += (sensor->interval_s == 0.0 ? 1.0 : kNew) * (since_s - sensor->interval_s);
  }
  return true;
}

std::string SensorWatch::forget() {
  std::string names;
  for (const auto& [name, sensor] : sensors_) add_words(names, name, ", ");
  sensors_.clear();
  pantilt_came_ = {};
  return names;
}

const SensorInfo* SensorWatch::info_of(const std::string& name) const {
  const auto at = sensors_.find(name);
  return at == sensors_.end() || !at->second.info ? nullptr : &*at->second.info;
}

std::optional<Pose3> SensorWatch::robot_from(const SensorInfo& laser, Utime now) const {
  std::optional<PanTiltAngles> head;
  if (is_within(kRecentS, pantilt_came_, now)) head = pantilt_.angles();
  return robot_from_sensor(laser, info_of(kPanTilt), head);
}

Heights SensorWatch::counted(const Pose3& robot_from_laser) const {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  return is_level(robot_from_laser) ? Heights{-kAny, kAny} : body_;
}

std::string SensorWatch::silent(Utime now) const {
  for (const auto& [name, sensor] : sensors_) {
    const double since_s = (now - sensor.read).seconds();
    if (!sensor.info && name != kSonars) continue;
    if (sensor.interval_s == 0.0 || since_s <= patience_s(sensor.interval_s)) continue;
    return format("%s is silent for %.1f s", name.c_str(), since_s);
  }
  return "";
}

std::string SensorWatch::why_useless(const std::string& name,
                                     const Sensor& sensor,
                                     Utime now) const {
  if (!is_within(kRecentS, sensor.read, now)) return name + " is silent";
  if (name == kSonars) return "";
  if (!sensor.info) return name + " has no SENSOR_INFO";
  const auto robot_from_laser = robot_from(*sensor.info, now);
  if (!robot_from_laser) return name + " has no PANTILT_STATE";
  const bool on_robot = sensor.info->mount == SensorInfo::Mount::robot;
  const Sensor& mounted = on_robot ? sensor : sensors_.at(kPanTilt);
  if (is_within(kDisputeS, std::max(sensor.refused, mounted.refused), now)) {
    return name + " is in dispute";
  }
  if (mounted.info->parent_from_sensor.translation().z() == 0.0) {
    return name + " has no height (position_m)";
  }
  if (is_level(*robot_from_laser) && robot_from_laser->translation().z() > body_.highest_m) {
    return name + " is above the body (max_height_m)";
  }
  return is_within(kRecentS, sensor.useful, now) ? "" : name + " sees nothing at the body's height";
}

std::string SensorWatch::why_blind(Utime now) const {
  std::string reasons;
  for (const auto& [name, sensor] : sensors_) {
    if (name == kPanTilt || sensor.read == Utime{}) continue;
    const std::string why = why_useless(name, sensor, now);
    if (why.empty()) return "";
    add_words(reasons, why, ", ");
  }
  return reasons.empty() ? "no laser or sonar data" : reasons;
}

std::string SensorWatch::dispute(Utime now) const {
  for (const auto& [name, sensor] : sensors_) {
    if (is_within(kDisputeS, sensor.refused, now))
      return "another mount for " + name + " is refused";
  }
  return "";
}

}  // namespace marco::drivers
