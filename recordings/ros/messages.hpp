#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/pose3.hpp"
#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// The messages that Marco uses, as structs. Names and units are those of ROS' own definitions
/// (sensor_msgs, nav_msgs, geometry_msgs, tf2_msgs): metres, radians, seconds.
struct Header {
  int64_t stamp_ns = 0;
  std::string frame_id;  ///< without the leading slash that old tf wrote
};

struct LaserScanMessage {
  Header header;
  float angle_min = 0, angle_max = 0, angle_increment = 0;
  float time_increment = 0, scan_time = 0;
  float range_min = 0, range_max = 0;
  std::vector<float> ranges;
};

struct OdometryMessage {
  Header header;
  std::string child_frame_id;
  Pose3 pose = Pose3::Identity();
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
};

struct TransformMessage {
  Header header;  ///< of the parent frame
  std::string child_frame_id;
  Pose3 parent_from_child = Pose3::Identity();
};

struct ImuMessage {
  Header header;
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear_acceleration = Eigen::Vector3d::Zero();
  bool has_angular_velocity = true, has_acceleration = true;
};

struct PoseMessage {
  Header header;
  Pose3 pose = Pose3::Identity();
};

/// Positions of joints; those without one are left out.
struct JointStateMessage {
  Header header;
  std::vector<std::string> names;
  std::vector<double> positions_rad;  ///< one a name; [m] of a joint that slides
};

/// A cloud's points that are finite, in their order.
struct CloudMessage {
  Header header;
  std::vector<Eigen::Vector3f> points;
  std::vector<float> times_s;  ///< after the stamp, one a point; empty where the cloud has none
};

/// @throws WireError where bytes and type do not fit, and for encodings other than ros1, cdr, and
/// json as Foxglove's schemas define it. Multi-echo scans give their first echoes.
LaserScanMessage decode_scan(const Message& message);
OdometryMessage decode_odometry(const Message& message);
std::vector<TransformMessage> decode_transforms(const Message& message);
ImuMessage decode_imu(const Message& message);
PoseMessage decode_pose(const Message& message);
CloudMessage decode_cloud(const Message& message);
JointStateMessage decode_joints(const Message& message);

/// What a topic's type is good for.
enum class Use : uint8_t { none, scan, cloud, odometry, transforms, imu, pose, joints };
Use use_of(const Topic& topic);

/// A rotation of quaternions that are nearly of unit length, as tf accepts them; false for others.
bool make_pose(const Eigen::Vector3d& translation, const Eigen::Vector4d& xyzw, Pose3& pose);

}  // namespace marco::ros
