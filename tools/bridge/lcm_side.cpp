#include "tools/bridge/lcm_side.hpp"

#include <cmath>
#include <set>
#include <utility>

#include "common/grid_map.hpp"
#include "common/order_age.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/stamp.hpp"
#include "marco/maebot_encoders_t.hpp"
#include "marco/mbot_grid_t.hpp"
#include "marco/mbot_pose2d_t.hpp"
#include "marco/mbot_slam_reset_t.hpp"
#include "marco/ros_grid_t.hpp"
#include "marco/ros_laser_scan_t.hpp"
#include "marco/ros_odometry_t.hpp"
#include "marco/ros_path_t.hpp"

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

mbot_pose2d_t to_mbot(Utime utime, const Pose2& world_from_robot) {
  mbot_pose2d_t pose;
  pose.utime = utime.us;
  pose.x = static_cast<float>(world_from_robot.x_m);
  pose.y = static_cast<float>(world_from_robot.y_m);
  pose.theta = static_cast<float>(world_from_robot.theta_rad);
  return pose;
}

/// botlab reads cells as log odds within [-127, 127]: here the part of the way from "as likely free
/// as occupied" to certainty.
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

/// In the frame "map".
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

// MBot's names. What it drives along is on CONTROLLER_PATH: the way that was driven is not for it.
constexpr const char* kMbotPose = "SLAM_POSE";
constexpr const char* kMbotMap = "SLAM_MAP";
constexpr const char* kMbotReset = "MBOT_SYSTEM_RESET";
// As dimos names channels: topic#package.Type. Its planner's way to drive is on /path.
constexpr const char* kDimosPose = "/slam_pose#geometry_msgs.PoseStamped";
constexpr const char* kDimosMap = "/map#nav_msgs.OccupancyGrid";
constexpr const char* kDimosPath = "/marco/path#nav_msgs.Path";

template <class Message>
void send(process::Bus& bus, const char* channel, const Message& message, Utime utime) {
  bus.publish_raw(channel, encode_message(message), utime);
}

}  // namespace

LcmSide::LcmSide(process::LcmBus& bus,
                 ForeignTable table,
                 std::function<void(const std::string&)> say)
    : bus_(bus), sensors_(bus, std::move(table), std::move(say)) {}

void LcmSide::connect(MarcoSide& marco) {
  const auto pass_on = [this, &marco](const process::RawMessage& raw) {
    const auto sample = decode_sample(std::string(raw.channel), raw.bytes);
    if (!sample) return;
    if (const auto* scan = std::get_if<LaserScan>(&*sample)) behind_ = raw.event_time - scan->utime;
    marco.give(*sample);
  };
  for (const char* channel :
       {channels::kLidarPattern, channels::kOdometry, channels::kSensorInfo}) {
    sensors_.subscribe_raw(channel, [this, pass_on](const process::RawMessage& raw) {
      drops_.count_received();
      try {
        pass_on(raw);
      } catch (const std::invalid_argument& bad_message) {
        drops_.count(bad_message.what());
      }
    });
  }
  bus_.subscribe<mbot_slam_reset_t>(
      kMbotReset, drops_, [this, &marco](const auto& order, const auto& raw) {
        // By the clock of who stamps the scans: that robot's may differ from ours.
        require_fresh("mbot_slam_reset_t", stamp_of(order.utime), raw.event_time - behind_);
        require(order.slam_mode == mbot_slam_reset_t::FULL_SLAM,
                "mbot_slam_reset_t: only full SLAM can restart");
        marco.reset(order.retain_pose != 0 ? MarcoSide::Reset::map_only
                                           : MarcoSide::Reset::everything);
      });
}

LcmSide::Stack LcmSide::stack() const {
  static const std::set<std::string> kMbot = {fingerprint_of<lidar_raw_t>(),
                                              fingerprint_of<mbot_pose2d_t>(),
                                              fingerprint_of<maebot_encoders_t>()};
  static const std::set<std::string> kDimos = {fingerprint_of<ros_laser_scan_t>(),
                                               fingerprint_of<ros_odometry_t>(),
                                               fingerprint_of<ros_pose_stamped_t>()};
  const auto used = sensors_.used();
  for (const auto& [channel, type] : used) {
    if (kMbot.contains(type)) return Stack::mbot;
    if (kDimos.contains(type)) return Stack::dimos;
  }
  return used.empty() ? Stack::none : Stack::other;
}

void LcmSide::send_pose(const PoseEstimate& estimate) {
  const Stack to = stack();
  if (to == Stack::mbot) {
    send(bus_, kMbotPose, to_mbot(estimate.utime, estimate.world_from_robot), estimate.utime);
  } else if (to == Stack::dimos) {
    ros_pose_stamped_t pose;
    pose.header = to_ros_header(estimate.utime, ++sequence_);
    pose.pose = to_ros(estimate.world_from_robot);
    send(bus_, kDimosPose, pose, estimate.utime);
  }
}

void LcmSide::send_map(const GridMap& map, Utime utime) {
  const Stack to = stack();
  if (to == Stack::mbot) send(bus_, kMbotMap, to_mbot(map, utime), utime);
  if (to == Stack::dimos) send(bus_, kDimosMap, to_ros(map, utime, ++sequence_), utime);
}

void LcmSide::send_path(const Trajectory& path, Utime utime) {
  if (stack() == Stack::dimos) send(bus_, kDimosPath, to_ros(path, utime, ++sequence_), utime);
}

std::string LcmSide::state() const {
  std::string heard;
  for (const auto& [channel, type] : sensors_.used()) {
    heard += (heard.empty() ? "" : ", ") + channel;
  }
  switch (stack()) {
    case Stack::none:
      return "receives no known laser or odometry";
    case Stack::mbot:
      return "MBot: " + heard;
    case Stack::dimos:
      return "dimos: " + heard;
    case Stack::other:
      break;
  }
  return heard + "; nothing is sent back: the owner of these types is unknown";
}

}  // namespace marco::bridge
