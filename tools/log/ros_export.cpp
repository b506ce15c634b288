#include "tools/log/ros_export.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "common/regular_scan.hpp"
#include "lcmtypes/channels.hpp"
#include "recordings/ros/known_types.hpp"
#include "tools/log/robot_frames.hpp"

namespace marco::logs {
namespace {

constexpr const char* kTransforms = "tf2_msgs/TFMessage";
constexpr const char* kRobot = "base_link";

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return text;
}

// ROS' names (REP 105) for the frames of RobotFrames.
std::string ros_frame(const std::string& frame) {
  if (frame == "world") return "map";
  if (frame == "robot") return kRobot;
  return lower(frame);
}

int64_t ns_of(Utime utime) { return std::clamp<int64_t>(utime.us, 0, INT64_MAX / 1000) * 1000; }

// /scan of LIDAR, /scan_back of LIDAR_BACK.
std::string scan_topic(const std::string& laser) {
  const std::string plain = channels::kLidar;
  const bool is_named = laser.starts_with(plain + "_");
  if (laser == plain) return "/scan";
  return "/scan_" + lower(is_named ? laser.substr(plain.size() + 1) : laser);
}

float ros_range(float range_m, double range_max_m) {
  const bool returned = range_m > 0.0F && static_cast<double>(range_m) < range_max_m;
  return returned ? range_m : std::numeric_limits<float>::infinity();
}

// ROS 2 keeps the last message for late listeners only where the publisher says so: rosbag2 reads
// these lines of YAML (versions 4 to 8 of its metadata).
std::string kept_for_late_listeners() {
  const std::string forever = "\n    sec: 2147483647\n    nsec: 4294967295";
  return "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 1\n  deadline:" + forever +
         "\n  lifespan:" + forever + "\n  liveliness: 1\n  liveliness_lease_duration:" + forever +
         "\n  avoid_ros_namespace_conventions: false";
}

bool is_latched(const std::string& name) { return name == "/tf_static" || name == "/map"; }

}  // namespace

ros::Topic topic_of(const std::string& name, const std::string& type, const std::string& encoding) {
  const ros::KnownType& known = *ros::known_type(type);
  ros::Topic topic;
  topic.name = name;
  topic.type = type;
  topic.encoding = encoding;
  topic.schema_encoding = encoding == "cdr" ? "ros2msg" : "ros1msg";
  topic.schema = ros::definition_text(known, encoding);
  topic.md5 = known.md5;
  topic.is_latched = is_latched(name);
  if (encoding == "cdr") {
    topic.metadata["offered_qos_profiles"] = topic.is_latched ? kept_for_late_listeners() : "";
  }
  return topic;
}

void RosExport::write(const std::string& topic,
                      const char* type,
                      Utime utime,
                      const ros::Bytes& bytes) {
  const auto [known, is_new] = topics_.try_emplace(topic, 0);
  if (is_new) known->second = sink_.add_topic(topic_of(topic, type, sink_.encoding()));
  sink_.write(known->second, ns_of(utime), ns_of(utime), bytes);
  ++messages_;
}

void RosExport::add(const Sample& sample) {
  if (const auto* scan = std::get_if<LaserScan>(&sample)) add_scan(*scan);
  if (const auto* odometry = std::get_if<OdometrySample>(&sample)) add_odometry(*odometry);
  if (const auto* info = std::get_if<SensorInfo>(&sample)) add_info(*info);
  if (const auto* imu = std::get_if<ImuSample>(&sample)) add_imu(*imu);
  if (const auto* pose = std::get_if<TruePose>(&sample)) {
    const ros::PoseMessage message{{ns_of(pose->utime), "map"}, lift(pose->world_from_robot)};
    write("/ground_truth", "geometry_msgs/PoseStamped", pose->utime,
          ros::encode(sink_.encoding(), message));
  }
  if (const auto* state = std::get_if<PanTiltState>(&sample)) {
    const auto base = infos_.find(channels::kPanTiltState);
    if (base == infos_.end()) return;
    const foxglove::Transform plate = RobotFrames::of_plate(base->second, *state);
    add_transform(state->utime, plate.parent, plate.child, plate.parent_from_child);
  }
}

void RosExport::add_scan(const LaserScan& scan) {
  const std::string laser = channels::lidar_of(scan.channel);
  const std::string& channel = scan_channels_.try_emplace(laser, scan.channel).first->second;
  if (channel != scan.channel) {
    ++doubled_scans_;
    return;
  }
  const auto told = infos_.find(laser);
  const SensorInfo info = told == infos_.end() ? SensorInfo{} : told->second;
  const LaserScan regular = make_regular(scan, std::numeric_limits<float>::infinity());
  const double steps = static_cast<double>(regular.size()) - 1.0;
  ros::LaserScanMessage message;
  message.header = {ns_of(scan.utime), told == infos_.end() ? kRobot : lower(laser)};
  message.angle_min = static_cast<float>(regular.first_bearing_rad);
  message.angle_max =
      static_cast<float>(regular.first_bearing_rad + steps * regular.bearing_step_rad);
  message.angle_increment = static_cast<float>(regular.bearing_step_rad);
  // Beams that were put elsewhere have lost their times.
  if (scan.bearings_rad.empty() && steps > 0.0) {
    message.time_increment = static_cast<float>(info.scan_duration_s / steps);
  }
  message.range_min = static_cast<float>(info.range_min_m);
  message.range_max = static_cast<float>(info.range_max_m);
  message.ranges.reserve(regular.size());
  for (const float range_m : regular.ranges_m) {
    message.ranges.push_back(ros_range(range_m, info.range_max_m));
  }
  write(scan_topic(laser), "sensor_msgs/LaserScan", scan.utime,
        ros::encode(sink_.encoding(), message));
}

void RosExport::add_odometry(const OdometrySample& sample) {
  ros::OdometryMessage message;
  message.header = {ns_of(sample.utime), "odom"};
  message.child_frame_id = kRobot;
  message.pose = lift(sample.odom_from_robot);
  message.linear.x() = sample.velocity_m_per_s;
  message.angular.z() = sample.yaw_rate_rad_per_s;
  write("/odom", "nav_msgs/Odometry", sample.utime, ros::encode(sink_.encoding(), message));
  add_transform(sample.utime, "odom", "robot", message.pose);
  odometry_.add(sample.utime, sample.odom_from_robot);
}

// Repeated once a second, and in ROS said once.
void RosExport::add_info(const SensorInfo& info) {
  const auto [known, is_new] = infos_.try_emplace(info.channel, info);
  const bool is_same = !is_new && known->second.mount == info.mount &&
                       known->second.parent_from_sensor.isApprox(info.parent_from_sensor, 1e-9);
  known->second = info;
  if (is_same || info.channel == channels::kPanTiltState) return;  // a pan-tilt's plate moves
  const foxglove::Transform place = RobotFrames::of_sensor(info);
  const std::vector<ros::TransformMessage> message{{{ns_of(info.utime), ros_frame(place.parent)},
                                                    ros_frame(place.child),
                                                    place.parent_from_child}};
  write("/tf_static", kTransforms, info.utime, ros::encode(sink_.encoding(), message));
}

void RosExport::add_imu(const ImuSample& sample) {
  ros::ImuMessage message;
  message.header = {ns_of(sample.utime), kRobot};
  message.angular_velocity = sample.angular_velocity_rad_per_s;
  message.has_acceleration = sample.acceleration_m_per_s2.allFinite();
  if (message.has_acceleration) message.linear_acceleration = sample.acceleration_m_per_s2;
  write("/imu/data", "sensor_msgs/Imu", sample.utime, ros::encode(sink_.encoding(), message));
}

// A frame has one parent: with odometry, SLAM says where that began.
void RosExport::add_slam_pose(Utime utime, const Pose2& world_from_robot) {
  const ros::PoseMessage message{{ns_of(utime), "map"}, lift(world_from_robot)};
  write("/slam_pose", "geometry_msgs/PoseStamped", utime, ros::encode(sink_.encoding(), message));
  if (odometry_.empty()) return add_transform(utime, "world", "robot", message.pose);
  constexpr Duration kReach = Duration::from_us(200000);
  const Pose2 odom_from_robot = odometry_.at(utime, kReach).value_or(odometry_.newest_pose());
  add_transform(utime, "world", "odom", lift(world_from_robot * odom_from_robot.inverse()));
}

void RosExport::add_transform(Utime utime,
                              const std::string& parent,
                              const std::string& child,
                              const Pose3& parent_from_child) {
  const std::vector<ros::TransformMessage> message{
      {{ns_of(utime), ros_frame(parent)}, ros_frame(child), parent_from_child}};
  write("/tf", kTransforms, utime, ros::encode(sink_.encoding(), message));
}

void RosExport::add_path(Utime utime, const Trajectory& path) {
  std::vector<ros::PoseMessage> poses;
  poses.reserve(path.size());
  for (const StampedPose2& pose : path) {
    poses.push_back({{ns_of(pose.utime), "map"}, lift(pose.world_from_robot)});
  }
  write("/trajectory", "nav_msgs/Path", utime,
        ros::encode(sink_.encoding(), {ns_of(utime), "map"}, poses));
}

void RosExport::add_map(Utime utime, const GridMap& map) {
  write("/map", "nav_msgs/OccupancyGrid", utime,
        ros::encode(sink_.encoding(), {ns_of(utime), "map"}, map));
}

void RosExport::add_image(const std::string& channel, ros::ImageMessage image) {
  image.header.frame_id = infos_.contains(channel) ? lower(channel) : kRobot;
  const Utime utime = Utime::from_us(image.header.stamp_ns / 1000);
  const std::string topic = "/" + lower(channel) + "/image_raw";
  const ros::Bytes bytes = ros::encode(sink_.encoding(), image);
  if (image.step_bytes > 0) {
    write(topic, "sensor_msgs/Image", utime, bytes);
  } else {
    write(topic + "/compressed", "sensor_msgs/CompressedImage", utime, bytes);
  }
}

}  // namespace marco::logs
