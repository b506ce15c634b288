#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recordings/foreign.hpp"
#include "recordings/ros/message_source.hpp"
#include "recordings/ros/messages.hpp"
#include "recordings/ros/ros_plan.hpp"

namespace marco::ros {

/// Messages of ROS as samples, by a plan: of a recording, or of a live robot. Not thread-safe.
class RosSamples {
 public:
  RosSamples(RosPlan plan, const RosOptions& options);

  const RosPlan& plan() const { return plan_; }
  /// Whether messages of a topic give samples.
  bool wants(const Topic& topic) const;
  /// The samples of one message, in their order; with the first scan the sensors'.
  /// @throws std::invalid_argument saying what is wrong with the message.
  std::vector<Sample> take(const Message& message);

 private:
  Utime stamp_of(const Header& header, const Message& message, const std::string& key) const;
  void take_scan(const Message& message, const LaserPlan& laser);
  void announce(Utime utime);
  void take_odometry(const Message& message);
  void take_transform(const TransformMessage& transform, const Message& message);
  void take_joint(const TransformMessage& transform, const Message& message);
  void take_joints(const Message& message);
  void take_wheels(const JointStateMessage& joints, Utime utime);
  void take_imu(const Message& message);
  void take_truth(const Message& message);

  RosPlan plan_;
  RosOptions options_;
  bool announced_ = false;
  Utime last_transform_, last_joint_;
  PanTiltState pantilt_;                       // by joint states
  std::optional<Eigen::Vector2d> wheels_rad_;  // left, right
  Pose2 odom_from_robot_;                      // by the wheels
  std::vector<Sample> samples_;
};

}  // namespace marco::ros
