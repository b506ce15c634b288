#pragma once

#include "common/grid_map.hpp"
#include "common/trajectory.hpp"
#include "marco/mbot_grid_t.hpp"
#include "marco/mbot_pose2d_t.hpp"
#include "marco/ros_grid_t.hpp"
#include "marco/ros_path_t.hpp"

/// Marco's values as messages of MBot and, as structs of ROS over LCM, of dimos. Pure.
namespace marco::bridge {

mbot_pose2d_t to_mbot(Utime utime, const Pose2& world_from_robot);
/// botlab reads cells as log odds within [-127, 127]: here the part of the way from "as likely free
/// as occupied" to certainty.
mbot_grid_t to_mbot(const GridMap& map, Utime utime);

/// In the frame "map".
ros_header_t to_ros_header(Utime utime, int32_t sequence);
ros_pose_t to_ros(const Pose2& pose);
ros_grid_t to_ros(const GridMap& map, Utime utime, int32_t sequence);
ros_path_t to_ros(const Trajectory& path, Utime utime, int32_t sequence);

}  // namespace marco::bridge
