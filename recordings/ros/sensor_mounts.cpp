#include "recordings/ros/sensor_mounts.hpp"

#include <algorithm>
#include <cctype>

namespace marco::ros {
namespace {

bool is_odometry(const FrameEdge& edge) {
  return has(edge.parent, {"odom"}) || is_map_frame(edge.parent);
}

}  // namespace

bool has(const std::string& name, std::initializer_list<const char*> words) {
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return lower.find(word) != std::string::npos; });
}

bool names_truth(const std::string& name) {
  return has(name, {"truth", "gazebo", "vicon", "mocap", "optitrack", "/gt"});
}

bool is_map_frame(const std::string& frame) { return has(frame, {"map", "world"}); }

std::optional<Joint> SensorMounts::joint_above(const std::string& frame) const {
  for (const FrameEdge* edge : tree_.way_up(frame)) {
    if (!edge->moves()) continue;
    constexpr double kJointMovesM = 0.05;
    if (edge->moved_m > kJointMovesM || edge->turned_rad < 0.01 || is_odometry(*edge)) return {};
    return Joint{edge->parent, edge->child};
  }
  return std::nullopt;
}

bool SensorMounts::is_fixed_to(const std::string& a, const std::string& b) const {
  return a == b || tree_.fixed_pose(a, b).has_value();
}

bool SensorMounts::is_on_robot(const std::string& base, const std::string& sensor) const {
  if (base.empty() || sensor.empty()) return false;
  if (is_fixed_to(base, sensor)) return true;
  const auto joint = joint_above(sensor);
  return joint && is_fixed_to(base, joint->parent);
}

std::string SensorMounts::highest_on_robot(const std::string& frame) const {
  std::string highest;
  for (const FrameEdge* edge : tree_.way_up(frame)) {
    if (is_odometry(*edge) || !is_on_robot(edge->parent, frame)) break;
    highest = edge->parent;
  }
  return highest;
}

}  // namespace marco::ros
