#pragma once

#include <filesystem>
#include <memory>

#include "recordings/foreign.hpp"
#include "recordings/ros/message_source.hpp"
#include "recordings/sample_reader.hpp"

namespace marco::ros {

/// A recording of ROS messages as samples, in the order of receipt; no flag is needed. It is read
/// twice: first to learn lasers, frames, odometry and clocks (ros_plan.hpp), of which each decision
/// is a note of the report. Stamps are those of the messages; a message without one is stamped by
/// the recorder.
/// @throws std::invalid_argument "no laser: ..." with what there is instead.
std::unique_ptr<files::SampleReader> open_ros(std::unique_ptr<MessageSource> source,
                                              const RosOptions& options);

}  // namespace marco::ros
