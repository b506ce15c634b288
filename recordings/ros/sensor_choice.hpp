#pragma once

#include "recordings/ros/ros_plan.hpp"

namespace marco::ros {

/// The lasers of a recording, the one that leads first.
/// @throws std::invalid_argument "no laser: ..." with what there is instead.
std::vector<const SurveyedTopic*> lasers_by_merit(const RosSurvey& survey,
                                                  const RosOptions& options);

/// Places a laser on the robot by its frames and joints, and adds it to the plan, or a note why it
/// is ignored.
void add_laser(const RosSurvey& survey, const SurveyedTopic& laser, RosPlan& plan);

/// Which topic, transform or wheels are the odometry of the robot that carries a laser, and which
/// frame is the robot's.
/// @throws std::invalid_argument where an option names what there is not.
void choose_odometry(const RosSurvey& survey,
                     const RosOptions& options,
                     const SurveyedTopic& laser,
                     RosPlan& plan);

}  // namespace marco::ros
