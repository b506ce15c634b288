#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/grid_map.hpp"
#include "common/trajectory.hpp"
#include "recordings/ros/messages.hpp"

/// Marco's values as messages of ROS; the reverse of messages.hpp.
/// @param encoding "ros1" or "cdr"
namespace marco::ros {

/// nav_msgs/OccupancyGrid; cells that are not known are -1.
std::vector<uint8_t> encode_grid(std::string_view encoding,
                                 const Header& header,
                                 const GridMap& map);
/// geometry_msgs/PoseStamped
std::vector<uint8_t> encode_pose(std::string_view encoding, const PoseMessage& pose);
/// nav_msgs/Path; each pose has its own stamp.
std::vector<uint8_t> encode_path(std::string_view encoding,
                                 const Header& header,
                                 const Trajectory& path);
/// tf2_msgs/TFMessage
std::vector<uint8_t> encode_transforms(std::string_view encoding,
                                       const std::vector<TransformMessage>& transforms);

}  // namespace marco::ros
