#pragma once

#include <vector>

#include "recordings/ros/messages.hpp"

namespace marco::ros {

/// Messages in JSON of Foxglove's schemas, such as those that `marco log convert` writes.
/// @throws WireError where a field is missing or of another kind.
LaserScanMessage json_scan(const Message& message);
std::vector<TransformMessage> json_transforms(const Message& message);
PoseMessage json_pose(const Message& message);

}  // namespace marco::ros
