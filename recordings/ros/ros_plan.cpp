#include "recordings/ros/ros_plan.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

#include "lcm_tools/base/check.hpp"
#include "recordings/name_list.hpp"
#include "recordings/ros/sensor_choice.hpp"

namespace marco::ros {
namespace {

bool is_odometry(const FrameEdge& edge) {
  return has(edge.parent, {"odom"}) || is_map_frame(edge.parent);
}

constexpr double kJointMovesRad = 0.01;

bool moves(const SurveyedTopic& topic, const std::string& joint) {
  const auto found = topic.joints.find(joint);
  return found != topic.joints.end() &&
         found->second.most_rad - found->second.least_rad > kJointMovesRad;
}

class Planner {
 public:
  Planner(const RosSurvey& survey, const RosOptions& options)
      : survey_(survey), options_(options) {}

  RosPlan plan() {
    const std::vector<const SurveyedTopic*> lasers = lasers_by_merit(survey_, options_);
    choose_odometry(survey_, options_, *lasers.front(), plan_);
    for (const SurveyedTopic* laser : lasers) add_laser(survey_, *laser, plan_);
    choose_imu();
    plan_.truth_topic = options_.truth;
    require(options_.truth.empty() || survey_.topics.contains(options_.truth),
            "ros.truth: there is no topic " + options_.truth + "; " + survey_.contents());
    align_clocks();
    for (const auto& [name, topic] : survey_.topics) note_unused(topic);
    note_others();
    return std::move(plan_);
  }

 private:
  void choose_imu() {
    for (const auto& [name, topic] : survey_.topics) {
      if (topic.use != Use::imu || topic.count < 2) continue;
      const auto current = survey_.topics.find(plan_.imu_topic);
      if (current != survey_.topics.end() && current->second.count >= topic.count) continue;
      plan_.imu_topic = name;
      const auto placed = plan_.base_frame.empty()
                              ? std::nullopt
                              : survey_.tree.fixed_pose(plan_.base_frame, topic.frame_id);
      plan_.base_from_imu = placed.value_or(Pose3::Identity());
    }
    if (plan_.imu_topic.empty()) return;
    // Two turns a second: no robot that maps does it.
    constexpr double kFastestRadPerS = 4.0 * std::numbers::pi;
    const double fastest = survey_.topics.at(plan_.imu_topic).fastest_turn;
    const bool in_degrees = fastest > kFastestRadPerS;
    if (in_degrees) plan_.rad_per_imu_unit = deg_to_rad(1.0);
    plan_.note("gyroscope %s%s", plan_.imu_topic.c_str(),
               in_degrees
                   ? ": its rates are degrees per second, contrary to the message's definition"
                   : "");
  }

  // Computers whose clocks disagree: by the delay from stamp to recorder, which else is alike.
  void align_clocks() {
    constexpr double kClocksApartS = 0.5;
    const StampDelays& laser = survey_.topics.at(plan_.lasers.front().topic).delays;
    plan_.received_shift_ns = -std::llround(1e9 * laser.least_s());
    const auto align = [&](const std::string& key, const std::string& name,
                           const StampDelays& delays) {
      if (delays.empty() || laser.empty()) return;
      const double behind_s = delays.longer_s(laser);
      if (std::abs(behind_s) < kClocksApartS) return;
      plan_.shift_ns[key] = std::llround(1e9 * behind_s);
      plan_.note("the clock of %s is %.3f s %s the laser's: its stamps are moved", name.c_str(),
                 std::abs(behind_s), behind_s > 0.0 ? "behind" : "ahead of");
    };
    for (const auto& [name, topic] : survey_.topics) {
      if (is_used_sensor(name) || plan_.uses_laser(name)) align(name, name, topic.delays);
      const bool lacks_stamps = topic.zero_stamps > 0 && topic.use != Use::transforms;
      if (lacks_stamps && (is_used_sensor(name) || plan_.uses_laser(name))) {
        plan_.note("%s: %lld of %lld messages have no stamp: using the time of receipt",
                   name.c_str(), static_cast<long long>(topic.zero_stamps),
                   static_cast<long long>(topic.count));
      }
    }
    const auto align_transform = [&](const char* key, const Joint& joint) {
      const auto found = survey_.transform_delays.find({joint.child, joint.parent});
      if (found != survey_.transform_delays.end()) {
        align(key, "tf from " + joint.parent + " to " + joint.child, found->second);
      }
    };
    align_transform(kTfClock, {plan_.odometry_parent, plan_.base_frame});
    for (const Joint& joint : plan_.joints) align_transform(kJointClock, joint);
  }

  bool is_used_sensor(const std::string& topic) const {
    return topic == plan_.odometry_topic || topic == plan_.imu_topic ||
           topic == plan_.truth_topic || plan_.uses_joints(topic);
  }

  void note_unused(const SurveyedTopic& topic) {
    const bool is_other =
        topic.use == Use::none || topic.use == Use::transforms || topic.use == Use::joints;
    if (is_other || plan_.uses_laser(topic.name) || is_used_sensor(topic.name)) return;
    plan_.note("%s (%s): %lld messages ignored", topic.name.c_str(), topic.type.c_str(),
               static_cast<long long>(topic.count));
  }

  // Pictures, commands, ...: of types that make no map.
  void note_others() {
    NameList names;
    for (const auto& [name, topic] : survey_.topics) {
      const bool is_other = topic.use == Use::none || topic.use == Use::joints;
      if (is_other && !plan_.uses_joints(name)) names.add(name + " (" + topic.type + ")");
    }
    if (!names.empty()) plan_.notes.push_back("not used: " + names.text());
  }

  const RosSurvey& survey_;
  const RosOptions& options_;
  RosPlan plan_;
};

}  // namespace

bool has(const std::string& name, std::initializer_list<const char*> words) {
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return lower.find(word) != std::string::npos; });
}

bool names_truth(const std::string& name) {
  return has(name, {"truth", "gazebo", "vicon", "mocap", "optitrack", "/gt"});
}

bool is_map_frame(const std::string& frame) { return has(frame, {"map", "world"}); }

std::optional<Joint> SensorMounts::joint_above(const std::string& frame) const {
  for (const FrameEdge* edge : tree_.way_up(frame)) {
    if (!edge->moves()) continue;
    constexpr double kJointMovesM = 0.05;
    if (edge->moved_m > kJointMovesM || edge->turned_rad < 0.01 || is_odometry(*edge)) return {};
    return Joint{edge->parent, edge->child};
  }
  return std::nullopt;
}

bool SensorMounts::is_fixed_to(const std::string& a, const std::string& b) const {
  return a == b || tree_.fixed_pose(a, b).has_value();
}

bool SensorMounts::is_on_robot(const std::string& base, const std::string& sensor) const {
  if (base.empty() || sensor.empty()) return false;
  if (is_fixed_to(base, sensor)) return true;
  const auto joint = joint_above(sensor);
  return joint && is_fixed_to(base, joint->parent);
}

std::string SensorMounts::highest_on_robot(const std::string& frame) const {
  std::string highest;
  for (const FrameEdge* edge : tree_.way_up(frame)) {
    if (is_odometry(*edge) || !is_on_robot(edge->parent, frame)) break;
    highest = edge->parent;
  }
  return highest;
}

std::optional<PanTiltJoints> pantilt_joints(const RosSurvey& survey, const SurveyedTopic& laser) {
  const bool laser_moves = has(laser.name + laser.frame_id, {"tilt", "nod", "pan"});
  for (const auto& [name, topic] : survey.topics) {
    PanTiltJoints found{name, "", ""};
    for (const auto& [joint, span] : topic.joints) {
      const bool is_meant = laser_moves || has(joint, {"laser", "lidar", "hokuyo", "sick", "scan"});
      if (!is_meant || !moves(topic, joint)) continue;
      if (has(joint, {"tilt", "nod"})) {
        found.tilt = joint;
      } else if (has(joint, {"pan"})) {
        found.pan = joint;
      }
    }
    if (!found.tilt.empty() || !found.pan.empty()) return found;
  }
  return std::nullopt;
}

std::optional<WheelJoints> wheel_joints(const RosSurvey& survey) {
  for (const auto& [name, topic] : survey.topics) {
    for (const auto& [joint, span] : topic.joints) {
      const auto at = joint.find("left");
      if (at == std::string::npos || !has(joint, {"wheel"})) continue;
      std::string right = joint;
      right.replace(at, 4, "right");
      const bool has_both = topic.joints.contains(right);
      if (has_both && (moves(topic, joint) || moves(topic, right))) {
        return WheelJoints{name, joint, right};
      }
    }
  }
  return std::nullopt;
}

void RosPlan::note(const char* format, ...) {
  std::array<char, 400> text{};
  va_list values;
  va_start(values, format);
  std::vsnprintf(text.data(), text.size(), format, values);
  va_end(values);
  notes.emplace_back(text.data());
}

bool RosPlan::uses_laser(const std::string& topic) const {
  return std::any_of(lasers.begin(), lasers.end(),
                     [&](const LaserPlan& laser) { return laser.topic == topic; });
}

bool RosPlan::uses_joints(const std::string& topic) const {
  return (wheels && wheels->topic == topic) || (pantilt_joints && pantilt_joints->topic == topic);
}

RosPlan plan_of(const RosSurvey& survey, const RosOptions& options) {
  return Planner(survey, options).plan();
}

}  // namespace marco::ros
