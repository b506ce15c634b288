#pragma once

#include "recordings/ros/ros_plan.hpp"

namespace marco::ros {

/// Which topic, transform or wheels are the odometry of the robot that carries a laser, and which
/// frame is the robot's.
/// @throws std::invalid_argument where an option names what there is not.
void choose_odometry(const RosSurvey& survey,
                     const RosOptions& options,
                     const SurveyedTopic& laser,
                     RosPlan& plan);

}  // namespace marco::ros
