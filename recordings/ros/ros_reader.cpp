#include "recordings/ros/ros_reader.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "common/pose3.hpp"
#include "lcm_tools/base/check.hpp"
#include "recordings/ros/ros_plan.hpp"
#include "recordings/ros/ros_scan.hpp"
#include "recordings/ros/ros_survey.hpp"
#include "recordings/ros/wire_reader.hpp"

namespace marco::ros {
namespace {

Utime utime_of(int64_t ns) { return Utime::from_us(ns / 1000); }

class RosReader : public files::QueuedReader {
 public:
  RosReader(std::unique_ptr<MessageSource> source, const RosOptions& options)
      : source_(std::move(source)), options_(options) {
    const RosSurvey seen = survey(*source_);
    plan_ = plan_of(seen, options_);
    report_.format = source_->format();
    report_.paths = source_->paths();
    report_.notes = plan_.notes;
    for (const LaserPlan& laser : plan_.lasers) wanted_.insert(laser.topic);
    for (const std::string& topic : {plan_.odometry_topic, plan_.imu_topic, plan_.truth_topic}) {
      if (!topic.empty()) wanted_.insert(topic);
    }
    const bool uses_tf = !plan_.odometry_parent.empty() || !plan_.joints.empty();
    source_->select([this, uses_tf](const Topic& topic) {
      return wanted_.contains(topic.name) || (uses_tf && use_of(topic) == Use::transforms);
    });
  }

  double progress() const override { return source_->progress(); }

 private:
  bool read_piece() override {
    const auto message = source_->next();
    if (!message) return false;
    try {
      read(*message);
    } catch (const std::invalid_argument& fault) {
      report_.drop(fault.what(), message->topic->name);
    }
    return true;
  }

  void read(const Message& message) {
    const std::string& topic = message.topic->name;
    for (const LaserPlan& laser : plan_.lasers) {
      if (laser.topic == topic) return read_scan(message, laser);
    }
    if (topic == plan_.odometry_topic) return read_odometry(message);
    if (topic == plan_.imu_topic) return read_imu(message);
    if (topic == plan_.truth_topic) return read_truth(message);
    for (const TransformMessage& transform : decode_transforms(message)) {
      read_transform(transform, message);
    }
  }

  Utime stamp_of(const Header& header, const Message& message, const std::string& key) const {
    if (header.stamp_ns == 0) return utime_of(message.received_ns);
    const auto shift = plan_.shift_ns.find(key);
    return utime_of(header.stamp_ns + (shift == plan_.shift_ns.end() ? 0 : shift->second));
  }

  void read_scan(const Message& message, const LaserPlan& laser) {
    LaserScan scan;
    Header header;
    if (laser.is_cloud) {
      CloudMessage cloud = decode_cloud(message);
      header = cloud.header;
      scan.utime = stamp_of(header, message, laser.topic);
      const Utime utime = scan.utime;
      scan = to_scan(cloud, laser, options_);
      scan.utime = utime;
    } else {
      const LaserScanMessage raw = decode_scan(message);
      scan = to_scan(raw, laser, options_);
      const Utime begun = scan.utime;  // relative: what the stamped beam makes of 0
      scan.utime = stamp_of(raw.header, message, laser.topic) + (begun - Utime{});
    }
    // The first laser leads: what it is matched with begins with it.
    if (!announced_ && &laser != &plan_.lasers.front()) return;
    announce(scan.utime);
    ++report_.given["scans"];
    queue(std::move(scan));
  }

  void announce(Utime utime) {
    if (std::exchange(announced_, true)) return;
    if (plan_.pantilt) {
      plan_.pantilt->utime = utime;
      queue(*plan_.pantilt);
    }
    for (LaserPlan& laser : plan_.lasers) {
      laser.info.utime = utime;
      queue(laser.info);
      ++report_.given["sensor infos"];
    }
  }

  void read_odometry(const Message& message) {
    const OdometryMessage odometry = decode_odometry(message);
    require(odometry.pose.translation().allFinite(), "pose that is not finite");
    OdometrySample sample;
    sample.utime = stamp_of(odometry.header, message, plan_.odometry_topic);
    sample.odom_from_robot = flatten(odometry.pose);
    sample.velocity_m_per_s = odometry.linear.x();
    sample.yaw_rate_rad_per_s = odometry.angular.z();
    ++report_.given["odometry"];
    queue(sample);
  }

  void read_transform(const TransformMessage& transform, const Message& message) {
    if (!transform.parent_from_child.translation().allFinite()) return;
    if (transform.header.frame_id == plan_.odometry_parent &&
        transform.child_frame_id == plan_.base_frame) {
      const Utime utime = stamp_of(transform.header, message, "tf");
      if (utime == last_transform_) return;  // repeated by another publisher
      last_transform_ = utime;
      ++report_.given["odometry"];
      queue_odometry(utime, flatten(transform.parent_from_child));
    }
    for (const Joint& joint : plan_.joints) {
      if (transform.child_frame_id != joint.child) continue;
      const Eigen::Matrix3d& turn = transform.parent_from_child.linear();
      PanTiltState state;
      state.utime = stamp_of(transform.header, message, "tf");
      if (state.utime <= last_joint_) continue;
      last_joint_ = state.utime;
      state.pan_rad = std::atan2(turn(1, 0), turn(0, 0));
      state.tilt_rad = std::asin(std::clamp(turn(2, 0), -1.0, 1.0));
      ++report_.given["pan-tilt"];
      queue(state);
    }
  }

  void read_imu(const Message& message) {
    const ImuMessage imu = decode_imu(message);
    if (!imu.has_angular_velocity) return;
    ImuSample sample;
    sample.utime = stamp_of(imu.header, message, plan_.imu_topic);
    sample.angular_velocity_rad_per_s =
        plan_.rad_per_imu_unit * (plan_.base_from_imu.linear() * imu.angular_velocity);
    if (imu.has_acceleration) {
      sample.acceleration_m_per_s2 = plan_.base_from_imu.linear() * imu.linear_acceleration;
    }
    ++report_.given["imu"];
    queue(sample);
  }

  void read_truth(const Message& message) {
    const PoseMessage pose = decode_pose(message);
    require(pose.pose.translation().allFinite(), "pose that is not finite");
    ++report_.given["true poses"];
    queue(TruePose{stamp_of(pose.header, message, plan_.truth_topic), flatten(pose.pose)});
  }

  void finish_report() override {
    for (const std::string& line : source_->notes()) report_.notes.push_back(line);
    const Damage& damage = source_->damage();
    if (damage.is_cut_off)
      note("the recording ends within a record: the recorder was stopped hard");
    if (damage.places == 0) return;
    report_.dropped["damaged stretches"] = damage.places;
    report_.places["damaged stretches"] = "byte " + std::to_string(damage.first_offset);
    note("%lld damaged bytes skipped", static_cast<long long>(damage.bytes));
  }

  std::unique_ptr<MessageSource> source_;
  RosOptions options_;
  RosPlan plan_;
  std::set<std::string> wanted_;
  bool announced_ = false;
  Utime last_transform_, last_joint_;
};

}  // namespace

std::unique_ptr<files::SampleReader> open_ros(std::unique_ptr<MessageSource> source,
                                              const RosOptions& options) {
  constexpr const char* kBeams[] = {"first", "middle", "last"};
  require(std::any_of(std::begin(kBeams), std::end(kBeams),
                      [&](const char* beam) { return options.stamp == beam; }),
          "ros.stamp: first, middle or last, not '" + options.stamp + "'");
  return std::make_unique<RosReader>(std::move(source), options);
}

}  // namespace marco::ros
