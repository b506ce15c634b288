#include "recordings/ros/joint_choice.hpp"

#include "recordings/ros/sensor_mounts.hpp"

namespace marco::ros {
namespace {

constexpr double kJointMovesRad = 0.01;

bool moves(const SurveyedTopic& topic, const std::string& joint) {
  const auto found = topic.joints.find(joint);
  return found != topic.joints.end() &&
         found->second.most_rad - found->second.least_rad > kJointMovesRad;
}

}  // namespace

std::optional<PanTiltJoints> pantilt_joints(const RosSurvey& survey, const SurveyedTopic& laser) {
  const bool laser_moves = has(laser.name + laser.frame_id, {"tilt", "nod", "pan"});
  for (const auto& [name, topic] : survey.topics) {
    PanTiltJoints found{name, "", ""};
    for (const auto& [joint, span] : topic.joints) {
      const bool is_meant = laser_moves || has(joint, {"laser", "lidar", "hokuyo", "sick", "scan"});
      if (!is_meant || !moves(topic, joint)) continue;
      if (has(joint, {"tilt", "nod"})) {
        found.tilt = joint;
      } else if (has(joint, {"pan"})) {
        found.pan = joint;
      }
    }
    if (!found.tilt.empty() || !found.pan.empty()) return found;
  }
  return std::nullopt;
}

std::optional<WheelJoints> wheel_joints(const RosSurvey& survey) {
  for (const auto& [name, topic] : survey.topics) {
    for (const auto& [joint, span] : topic.joints) {
      const auto at = joint.find("left");
      if (at == std::string::npos || !has(joint, {"wheel"})) continue;
      std::string right = joint;
      right.replace(at, 4, "right");
      const bool has_both = topic.joints.contains(right);
      if (has_both && (moves(topic, joint) || moves(topic, right))) {
        return WheelJoints{name, joint, right};
      }
    }
  }
  return std::nullopt;
}

}  // namespace marco::ros
