#include "tools/bridge/ros_output.hpp"

#include <utility>

#include "recordings/ros/encode_messages.hpp"

namespace marco::bridge {
namespace {

constexpr const char* kMapFrame = "map";  // REP 105
constexpr uint32_t kMap = 1, kPose = 2, kPath = 3, kTransforms = 4;
// Into the future, as other localizers of ROS do: who asks for the transform of now finds it until
// the next scan. slam_toolbox's default.
constexpr Duration kHoldsFor = Duration::from_us(200'000);
constexpr Duration kOdometryReach = Duration::from_us(500'000);

int64_t ns_of(Utime utime) { return utime.us * 1000; }

}  // namespace

RosOutput::RosOutput(std::function<bool(std::vector<uint8_t>)> send) : send_(std::move(send)) {}

std::optional<std::string> RosOutput::open(const foxglove::ServerInfo& server) {
  encoding_.clear();
  trouble_.clear();
  if (!server.capabilities.contains("clientPublish")) {
    trouble_ = "the robot's bridge accepts no messages (capability clientPublish)";
    return std::nullopt;
  }
  for (const char* encoding : {"cdr", "ros1"}) {
    if (server.encodings.contains(encoding)) encoding_ = encoding;
    if (!encoding_.empty()) break;
  }
  if (encoding_.empty()) {
    trouble_ = "the robot's bridge accepts neither cdr nor ros1";
    return std::nullopt;
  }
  const auto type = [this](const std::string& package, const std::string& name) {
    return package + (encoding_ == "cdr" ? "/msg/" : "/") + name;
  };
  return foxglove::advertise_text(
      {{kMap, "/map", encoding_, type("nav_msgs", "OccupancyGrid")},
       {kPose, "/slam_pose", encoding_, type("geometry_msgs", "PoseStamped")},
       {kPath, "/marco/path", encoding_, type("nav_msgs", "Path")},
       {kTransforms, "/tf", encoding_, type("tf2_msgs", "TFMessage")}});
}

void RosOutput::send(uint32_t channel, const std::vector<uint8_t>& payload) {
  send_(foxglove::data_message(channel, payload));
}

void RosOutput::note(const OdometrySample& odometry) {
  odometry_.add(odometry.utime, odometry.odom_from_robot);
}

void RosOutput::send_pose(const PoseEstimate& estimate) {
  if (encoding_.empty()) return;
  const ros::Header header{ns_of(estimate.utime), kMapFrame};
  send(kPose, ros::encode(encoding_, ros::PoseMessage{header, lift(estimate.world_from_robot)}));
  send_transform(estimate);
}

void RosOutput::send_transform(const PoseEstimate& estimate) {
  if (!frames_ || frames_->robot.empty()) return;
  ros::TransformMessage transform;
  transform.header = {ns_of(estimate.utime + kHoldsFor), kMapFrame};
  transform.child_frame_id = frames_->robot;
  transform.parent_from_child = lift(estimate.world_from_robot);
  if (!frames_->odom.empty()) {
    const auto odom_from_robot = odometry_.at(estimate.utime, kOdometryReach);
    if (!odom_from_robot) return;
    transform.child_frame_id = frames_->odom;
    transform.parent_from_child = lift(estimate.world_from_robot * odom_from_robot->inverse());
  }
  send(kTransforms, ros::encode(encoding_, std::vector<ros::TransformMessage>{transform}));
}

void RosOutput::send_map(const GridMap& map, Utime utime) {
  map_ = {map, utime};
  send_map_again();
}

void RosOutput::send_map_again() {
  if (encoding_.empty() || !map_) return;
  send(kMap, ros::encode(encoding_, ros::Header{ns_of(map_->second), kMapFrame}, map_->first));
}

void RosOutput::send_path(const Trajectory& path, Utime utime) {
  if (encoding_.empty()) return;
  std::vector<ros::PoseMessage> poses;
  poses.reserve(path.size());
  for (const StampedPose2& pose : path) {
    poses.push_back({{ns_of(pose.utime), kMapFrame}, lift(pose.world_from_robot)});
  }
  send(kPath, ros::encode(encoding_, ros::Header{ns_of(utime), kMapFrame}, poses));
}

}  // namespace marco::bridge
