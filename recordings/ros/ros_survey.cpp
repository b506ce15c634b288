#include "recordings/ros/ros_survey.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/median.hpp"
#include "common/pose2.hpp"
#include "recordings/looking_through.hpp"
#include "recordings/name_list.hpp"
#include "recordings/no_return_range.hpp"
#include "recordings/ros/wire_reader.hpp"

namespace marco::ros {
namespace {

constexpr std::size_t kMostPeriods = 1000;
constexpr std::size_t kMostTopics = 1000, kMostClocks = 1000;  // more than any robot has
constexpr float kFlatM = 0.02F;

struct Running {
  std::optional<int64_t> stamp_ns;
  std::vector<double> periods_s;
  std::optional<Pose2> pose;
  std::optional<NoReturnRange> no_return;
};

class Surveyor {
 public:
  explicit Surveyor(MessageSource& source) : source_(source) {}

  RosSurvey run() {
    source_.select([](const Topic& topic) { return use_of(topic) != Use::none; });
    const std::vector<std::string> paths = source_.paths();
    std::optional<LookingThrough> progress;  // of a live source there is none
    if (!paths.empty()) progress.emplace(paths.front());
    while (const auto message = source_.next()) {
      look(*message);
      if (progress) progress->update(source_.progress());
    }
    for (const Topic* topic : source_.topics()) {
      SurveyedTopic& seen = topic_of(*topic);
      if (seen.use == Use::none) seen.count += std::max<int64_t>(0, topic->messages);
    }
    for (auto& [name, topic] : survey_.topics) {
      const auto running = running_.find(name);
      if (running == running_.end()) continue;
      topic.period_s = median(running->second.periods_s);
      const auto& no_return = running->second.no_return;
      if (no_return) topic.no_return_m = no_return->range_m(0.0);
    }
    return std::move(survey_);
  }

 private:
  SurveyedTopic& topic_of(const Topic& topic) {
    SurveyedTopic& seen = survey_.topics[topic.name];
    seen.name = topic.name;
    seen.type = topic.type;
    seen.use = use_of(topic);
    return seen;
  }

  void look(const Message& message) {
    SurveyedTopic& topic = topic_of(*message.topic);
    if (running_.size() == kMostTopics && !running_.contains(topic.name)) return;
    try {
      decode(message, topic);
      ++topic.count;
    } catch (const WireError&) {
      ++topic.undecodable;
    }
  }

  void decode(const Message& message, SurveyedTopic& topic) {
    switch (topic.use) {
      case Use::scan:
        return look_at(decode_scan(message), message, topic);
      case Use::cloud:
        return look_at(decode_cloud(message), message, topic);
      case Use::odometry: {
        const OdometryMessage odometry = decode_odometry(message);
        topic.child_frame_id = odometry.child_frame_id;
        follow(odometry.pose, topic);
        return note_header(odometry.header, message, topic);
      }
      case Use::transforms:
        return look_at(decode_transforms(message), message, topic);
      case Use::imu: {
        const ImuMessage imu = decode_imu(message);
        const double turn = imu.angular_velocity.cwiseAbs().maxCoeff();
        topic.fastest_turn = std::max(topic.fastest_turn, turn);
        return note_header(imu.header, message, topic);
      }
      case Use::pose: {
        const PoseMessage pose = decode_pose(message);
        follow(pose.pose, topic);
        return note_header(pose.header, message, topic);
      }
      case Use::joints:
        return look_at(decode_joints(message), message, topic);
      case Use::none:
        return;
    }
  }

  void look_at(const LaserScanMessage& scan, const Message& message, SurveyedTopic& topic) {
    note_header(scan.header, message, topic);
    if (topic.beams == 0) {
      topic.first_scan = scan;
      topic.first_scan.ranges = {};
    }
    topic.beams = std::max(topic.beams, scan.ranges.size());
    std::optional<NoReturnRange>& no_return = running_[topic.name].no_return;
    if (!no_return) no_return.emplace();
    no_return->add(scan.ranges);
  }

  void look_at(const JointStateMessage& joints, const Message& message, SurveyedTopic& topic) {
    constexpr std::size_t kMostJoints = 200;
    note_header(joints.header, message, topic);
    for (std::size_t i = 0; i < joints.positions_rad.size(); ++i) {
      const double angle_rad = joints.positions_rad[i];
      if (!std::isfinite(angle_rad) || topic.joints.size() >= kMostJoints) continue;
      const auto [joint, is_new] =
          topic.joints.try_emplace(joints.names[i], SurveyedJoint{angle_rad, angle_rad});
      joint->second.least_rad = std::min(joint->second.least_rad, angle_rad);
      joint->second.most_rad = std::max(joint->second.most_rad, angle_rad);
    }
  }

  void look_at(const CloudMessage& cloud, const Message& message, SurveyedTopic& topic) {
    note_header(cloud.header, message, topic);
    topic.beams = std::max(topic.beams, cloud.points.size());
    for (const Eigen::Vector3f& point : cloud.points) {
      topic.is_flat = topic.is_flat && std::abs(point.z()) < kFlatM;
    }
    if (topic.is_flat) topic.bearings.add(cloud);
  }

  void look_at(const std::vector<TransformMessage>& transforms,
               const Message& message,
               SurveyedTopic& topic) {
    const bool is_static = topic.name.ends_with("tf_static");
    for (const TransformMessage& transform : transforms) {
      survey_.tree.add(transform, is_static);
      const std::pair frames(transform.child_frame_id, transform.header.frame_id);
      auto& delays = survey_.transform_delays;
      if (delays.size() == kMostClocks && !delays.contains(frames)) continue;
      delays[frames].add(message.received_ns, transform.header.stamp_ns);
    }
    if (!transforms.empty()) note_header(transforms.front().header, message, topic);
  }

  void note_header(const Header& header, const Message& message, SurveyedTopic& topic) {
    Running& running = running_[topic.name];
    if (header.stamp_ns == 0) {
      ++topic.zero_stamps;
      return;
    }
    const bool is_first = !running.stamp_ns;
    topic.delays.add(message.received_ns, header.stamp_ns);
    if (is_first) topic.frame_id = header.frame_id;
    if (!is_first && running.periods_s.size() < kMostPeriods) {
      running.periods_s.push_back(1e-9 * static_cast<double>(header.stamp_ns - *running.stamp_ns));
    }
    running.stamp_ns = header.stamp_ns;
  }

  void follow(const Pose3& pose, SurveyedTopic& topic) {
    if (!pose.translation().allFinite()) throw WireError("invalid pose");
    Running& running = running_[topic.name];
    const Pose2 now = flatten(pose);
    if (running.pose) {
      const Pose2 step = between(*running.pose, now);
      topic.way_m += step.translation_m().norm();
      topic.turned_rad += std::abs(step.theta_rad);
    }
    running.pose = now;
  }

  MessageSource& source_;
  RosSurvey survey_;
  std::map<std::string, Running> running_;  // by topic
};

}  // namespace

void StampDelays::add(int64_t received_ns, int64_t stamp_ns) {
  constexpr int64_t kPartNs = 5'000'000'000;
  constexpr std::size_t kMostParts = 5000;  // seven hours tell
  // As doubles: a damaged stamp may be as large as can be.
  const double delay_s = 1e-9 * (static_cast<double>(received_ns) - static_cast<double>(stamp_ns));
  if (least_s_.size() == kMostParts) return;
  const auto [least, is_new] = least_s_.try_emplace(received_ns / kPartNs, delay_s);
  least->second = std::min(least->second, delay_s);
}

double StampDelays::least_s() const {
  const auto least =
      std::min_element(least_s_.begin(), least_s_.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return least == least_s_.end() ? 0.0 : least->second;
}

double StampDelays::longer_s(const StampDelays& other) const {
  std::vector<double> longer_s;
  for (const auto& [part, delay_s] : least_s_) {
    const auto same = other.least_s_.find(part);
    if (same != other.least_s_.end()) longer_s.push_back(delay_s - same->second);
  }
  if (longer_s.empty()) return least_s() - other.least_s();
  return median(std::move(longer_s));
}

std::string RosSurvey::contents() const {
  NameList names;
  for (const auto& [name, topic] : topics) names.add(name + " (" + topic.type + ")");
  return names.empty() ? "it holds no messages" : "it holds " + names.text();
}

RosSurvey survey(MessageSource& source) { return Surveyor(source).run(); }

}  // namespace marco::ros
