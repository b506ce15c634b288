#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "recordings/ros/ros_reader.hpp"
#include "tests/support/recorded.hpp"
#include "tests/support/ros_wire.hpp"

namespace marco::testing {

/// What the scans of a RosRobot look like.
struct ScanShape {
  std::string frame = "laser";
  float first_rad = -1.0F, step_rad = 0.5F, time_step_s = 0.0F;
  std::optional<float> told_step_rad = {};  ///< otherwise than it is
  float range_max_m = 10.0F;
  std::vector<float> ranges_m{1.0F, 2.0F, 3.0F, 4.0F, 5.0F};
};

/// A robot's recording, put together message by message.
class RosRobot {
 public:
  void scan(double stamp_s, const ScanShape& shape = {}, const std::string& topic = "/scan") {
    RosWriter out(RosWriter::Form::cdr);
    const float last_rad =
        shape.first_rad + shape.step_rad * static_cast<float>(shape.ranges_m.size());
    out.header(stamp_s, shape.frame);
    out.numbers(std::vector<float>{shape.first_rad, last_rad,
                                   shape.told_step_rad.value_or(shape.step_rad), shape.time_step_s,
                                   0.1F, 0.05F, shape.range_max_m});
    out.number(static_cast<uint32_t>(shape.ranges_m.size())).numbers(shape.ranges_m);
    out.number(uint32_t{0});
    source_->add(topic, "sensor_msgs/LaserScan", stamp_s + late_s, out.bytes());
  }
  void odometry(double stamp_s,
                const Pose2& pose,
                double delay_s = 0.0,
                const std::string& topic = "/odom",
                const std::string& frame = "odom") {
    RosWriter out(RosWriter::Form::cdr);
    out.header(stamp_s, frame).text("base_link");
    write(out, lift(pose));
    out.numbers(std::vector<double>(36, 0.0));
    out.numbers(std::vector<double>{0.4, 0, 0, 0, 0, 0.3});
    out.numbers(std::vector<double>(36, 0.0));
    source_->add(topic, "nav_msgs/Odometry", stamp_s + delay_s + late_s, out.bytes());
  }
  void transform(double stamp_s,
                 const std::string& parent,
                 const std::string& child,
                 const Pose3& pose,
                 const std::string& topic = "/tf") {
    RosWriter out(RosWriter::Form::cdr);
    out.number(uint32_t{1}).header(stamp_s, parent).text(child);
    write(out, pose);
    source_->add(topic, "tf2_msgs/TFMessage", stamp_s + late_s, out.bytes());
  }
  void joints(double stamp_s, const std::map<std::string, double>& positions_rad) {
    RosWriter out(RosWriter::Form::cdr);
    out.header(stamp_s, "").number(static_cast<uint32_t>(positions_rad.size()));
    for (const auto& [name, position] : positions_rad) out.text(name);
    out.number(static_cast<uint32_t>(positions_rad.size()));
    for (const auto& [name, position] : positions_rad) out.number(position);
    out.number(uint32_t{0}).number(uint32_t{0});
    source_->add("/joint_states", "sensor_msgs/JointState", stamp_s + late_s, out.bytes());
  }
  void imu(double stamp_s, double yaw_rate) {
    RosWriter out(RosWriter::Form::cdr);
    out.header(stamp_s, "imu").numbers(std::vector<double>(4 + 9, 0.0));
    out.numbers(std::vector<double>{0, 0, yaw_rate}).numbers(std::vector<double>(9, 0.0));
    out.numbers(std::vector<double>{0, 0, 9.8}).numbers(std::vector<double>(9, 0.0));
    source_->add("/imu", "sensor_msgs/Imu", stamp_s, out.bytes());
  }
  void other(const std::string& topic, const std::string& type) {
    source_->add(topic, type, 1.0, {});
  }

  Recorded recorded(const RosOptions& options = {}) {
    return read_all(*ros::open_ros(std::move(source_), options));
  }

  double late_s = 0.0;  ///< of the recorder's clock

 private:
  static void write(RosWriter& out, const Pose3& pose) {
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d t = pose.translation();
    out.numbers(std::vector<double>{t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
  }

  std::unique_ptr<MemorySource> source_ = std::make_unique<MemorySource>();
};

}  // namespace marco::testing
