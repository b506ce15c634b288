#pragma once

#include <map>
#include <string>

#include "lcm_tools/log/select.hpp"
#include "recordings/ros/message_sink.hpp"

namespace marco::logs {

struct RosCopyResult {
  int64_t messages = 0;
  std::map<std::string, int64_t> left_out;  ///< by cause and type
};

/// Writes every message of a recording into another container. Bytes stay as they are where source
/// and sink are of one ROS; between ROS 1 and ROS 2 messages of ros::known_type are re-encoded,
/// and others left out.
RosCopyResult copy_messages(ros::MessageSource& source,
                            ros::MessageSink& sink,
                            const OnProgress& on_progress);

}  // namespace marco::logs
