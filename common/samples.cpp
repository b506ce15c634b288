#include "common/samples.hpp"

#include <cmath>

namespace marco {

bool is_steep(const Pose3& robot_from_sensor) {
  // A wall 2.5 m away is met 1.4 m higher or lower: by the ceiling, or not.
  constexpr double kSteepDeg = 30.0;
  return std::abs(robot_from_sensor.linear()(2, 2)) < std::cos(deg_to_rad(kSteepDeg));
}

bool note_sensor(std::map<std::string, SensorInfo>& by_channel, const SensorInfo& info) {
  constexpr std::size_t kMostChannels = 64;  // no robot carries more lasers and cameras
  if (by_channel.size() >= kMostChannels && !by_channel.contains(info.channel)) return false;
  by_channel[info.channel] = info;
  return true;
}

Pose3 robot_from_pantilt_sensor(const SensorInfo& base,
                                const SensorInfo& sensor,
                                double pan_rad,
                                double tilt_rad) {
  return base.parent_from_sensor * make_pose3(Eigen::Vector3d::Zero(), 0.0, 0.0, pan_rad) *
         make_pose3(base.tilt_axis_m, 0.0, -tilt_rad, 0.0) * sensor.parent_from_sensor;
}

std::optional<Pose3> robot_from_sensor(const SensorInfo& sensor,
                                       const SensorInfo* base,
                                       const std::optional<PanTiltAngles>& head) {
  if (sensor.mount == SensorInfo::Mount::robot) return sensor.parent_from_sensor;
  if (base == nullptr || !head) return std::nullopt;
  return robot_from_pantilt_sensor(*base, sensor, head->pan_rad, head->tilt_rad);
}

const SensorInfo* find_sensor(const std::map<std::string, SensorInfo>& by_channel,
                              const std::string& channel) {
  const auto found = by_channel.find(channel);
  return found == by_channel.end() ? nullptr : &found->second;
}

}  // namespace marco
