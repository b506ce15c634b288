#include "tools/bridge/foreign_values.hpp"

#include <cmath>

namespace marco::bridge {
namespace {

ros_time_t to_ros_time(Utime utime) {
  constexpr int64_t kSecondUs = 1'000'000;
  int64_t seconds = utime.us / kSecondUs, rest_us = utime.us % kSecondUs;
  if (rest_us < 0) {
    --seconds;
    rest_us += kSecondUs;
  }
  ros_time_t time;
  time.sec = static_cast<int32_t>(seconds);
  time.nsec = static_cast<int32_t>(rest_us * 1000);
  return time;
}

}  // namespace

mbot_pose2d_t to_mbot(Utime utime, const Pose2& world_from_robot) {
  mbot_pose2d_t pose;
  pose.utime = utime.us;
  pose.x = static_cast<float>(world_from_robot.x_m);
  pose.y = static_cast<float>(world_from_robot.y_m);
  pose.theta = static_cast<float>(world_from_robot.theta_rad);
  return pose;
}

mbot_grid_t to_mbot(const GridMap& map, Utime utime) {
  constexpr double kEvenPercent = 50.0, kMostOdds = 127.0;
  mbot_grid_t grid;
  grid.utime = utime.us;
  grid.origin_x = static_cast<float>(map.origin_m.x());
  grid.origin_y = static_cast<float>(map.origin_m.y());
  grid.meters_per_cell = static_cast<float>(map.resolution_m);
  grid.width = map.width_cells;
  grid.height = map.height_cells;
  grid.num_cells = static_cast<int32_t>(map.occupancy.size());
  grid.cells.reserve(map.occupancy.size());
  for (const uint8_t percent : map.occupancy) {
    const double certainty = (static_cast<double>(percent) - kEvenPercent) / kEvenPercent;
    const bool known = percent != GridMap::kUnknown;
    grid.cells.push_back(static_cast<int8_t>(known ? std::lround(kMostOdds * certainty) : 0));
  }
  return grid;
}

ros_header_t to_ros_header(Utime utime, int32_t sequence) {
  ros_header_t header;
  header.seq = sequence;
  header.stamp = to_ros_time(utime);
  header.frame_id = "map";
  return header;
}

ros_pose_t to_ros(const Pose2& pose) {
  ros_pose_t message = {};
  message.position.x = pose.x_m;
  message.position.y = pose.y_m;
  message.orientation.z = std::sin(0.5 * pose.theta_rad);
  message.orientation.w = std::cos(0.5 * pose.theta_rad);
  return message;
}

ros_grid_t to_ros(const GridMap& map, Utime utime, int32_t sequence) {
  ros_grid_t grid;
  grid.header = to_ros_header(utime, sequence);
  grid.info.map_load_time = grid.header.stamp;
  grid.info.resolution = static_cast<float>(map.resolution_m);
  grid.info.width = map.width_cells;
  grid.info.height = map.height_cells;
  grid.info.origin = to_ros(Pose2{map.origin_m.x(), map.origin_m.y(), 0.0});
  grid.data_length = static_cast<int32_t>(map.occupancy.size());
  grid.data.reserve(map.occupancy.size());
  for (const uint8_t percent : map.occupancy) {
    grid.data.push_back(static_cast<int8_t>(percent == GridMap::kUnknown ? -1 : percent));
  }
  return grid;
}

ros_path_t to_ros(const Trajectory& path, Utime utime, int32_t sequence) {
  ros_path_t message;
  message.header = to_ros_header(utime, sequence);
  message.poses_length = static_cast<int32_t>(path.size());
  for (const StampedPose2& pose : path) {
    ros_pose_stamped_t stamped;
    stamped.header = to_ros_header(pose.utime, sequence);
    stamped.pose = to_ros(pose.world_from_robot);
    message.poses.push_back(std::move(stamped));
  }
  return message;
}

}  // namespace marco::bridge
