#pragma once

#include <optional>
#include <string>

#include "recordings/ros/ros_survey.hpp"

namespace marco::ros {

/// Joints of one topic of sensor_msgs/JointState, by name; "" none.
struct PanTiltJoints {
  std::string topic, pan, tilt;
};
struct WheelJoints {
  std::string topic, left, right;
};

/// The joints that move a laser, where their names or the laser's say so.
std::optional<PanTiltJoints> pantilt_joints(const RosSurvey& survey, const SurveyedTopic& laser);

/// Two wheels that turn, of which the names differ by "left" and "right".
std::optional<WheelJoints> wheel_joints(const RosSurvey& survey);

}  // namespace marco::ros
