#include "tools/bridge/lcm_side.hpp"

#include <set>
#include <utility>

#include "common/order_age.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/stamp.hpp"
#include "marco/maebot_encoders_t.hpp"
#include "marco/mbot_slam_reset_t.hpp"
#include "marco/ros_laser_scan_t.hpp"
#include "marco/ros_odometry_t.hpp"
#include "tools/bridge/foreign_values.hpp"

namespace marco::bridge {
namespace {

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
