#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/pose_buffer.hpp"
#include "common/samples.hpp"
#include "common/trajectory.hpp"
#include "recordings/ros/encode_messages.hpp"
#include "recordings/ros/message_sink.hpp"

namespace marco::logs {

/// Writes measurements, and what SLAM made of them, as the messages that ROS' own programs take:
///
/// | value | topic | type |
/// |---|---|---|
/// | LaserScan | /scan; /scan_back of LIDAR_BACK | sensor_msgs/LaserScan in lidar, lidar_back |
/// | OdometrySample | /odom, /tf odom -> base_link | nav_msgs/Odometry |
/// | SensorInfo | /tf_static | tf2_msgs/TFMessage |
/// | PanTiltState | /tf base_link -> plate | tf2_msgs/TFMessage |
/// | ImuSample | /imu/data | sensor_msgs/Imu in base_link |
/// | TruePose | /ground_truth | geometry_msgs/PoseStamped in map |
/// | SLAM's pose | /slam_pose, /tf map -> odom, or map -> base_link without odometry | the same |
/// | the path | /trajectory | nav_msgs/Path |
/// | the map | /map | nav_msgs/OccupancyGrid |
/// | a picture | /camera/image_raw, /camera/image_raw/compressed | sensor_msgs/Image, .. |
///
/// Messages carry and are recorded at the time of what they say. Scans whose beams have bearings of
/// their own are put on regular ones (make_regular).
class RosExport {
 public:
  explicit RosExport(ros::MessageSink& sink) : sink_(sink) {}

  void add(const Sample& sample);
  void add_slam_pose(Utime utime, const Pose2& world_from_robot);
  void add_path(Utime utime, const Trajectory& path);
  void add_map(Utime utime, const GridMap& map);
  /// @param channel "CAMERA", ...
  void add_image(const std::string& channel, ros::ImageMessage image);

  int64_t messages() const { return messages_; }
  /// Scans of a laser that is on two channels are written once.
  int64_t doubled_scans() const { return doubled_scans_; }

 private:
  void add_transform(Utime utime,
                     const std::string& parent,
                     const std::string& child,
                     const Pose3& parent_from_child);
  void add_scan(const LaserScan& scan);
  void add_odometry(const OdometrySample& sample);
  void add_info(const SensorInfo& info);
  void add_imu(const ImuSample& sample);
  void write(const std::string& topic, const char* type, Utime utime, const ros::Bytes& bytes);

  ros::MessageSink& sink_;
  std::map<std::string, uint32_t> topics_;
  std::map<std::string, std::string> scan_channels_;  // the one that is written, by laser
  std::map<std::string, SensorInfo> infos_;           // by channel
  PoseBuffer odometry_;
  int64_t messages_ = 0;
  int64_t doubled_scans_ = 0;
};

/// A topic of a type that ros::known_type knows, with its definition, ready for a sink.
/// @param encoding of the sink
ros::Topic topic_of(const std::string& name, const std::string& type, const std::string& encoding);

}  // namespace marco::logs
