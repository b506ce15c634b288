#include "recordings/ros/ros_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

#include "lcm_tools/base/check.hpp"
#include "recordings/ros/laser_choice.hpp"
#include "recordings/ros/odometry_choice.hpp"

namespace marco::ros {
namespace {

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
    plan_.note(
        "gyroscope %s%s", plan_.imu_topic.c_str(),
        in_degrees ? ": its rates are degrees a second, against the message's definition" : "");
  }

  // Computers whose clocks disagree: by the delay from stamp to recorder, which else is alike.
  void align_clocks() {
    constexpr double kClocksApartS = 0.5;
    const double laser_s = survey_.topics.at(plan_.lasers.front().topic).least_delay_s;
    const auto align = [&](const std::string& key, const std::string& name, double delay_s) {
      if (std::abs(delay_s - laser_s) < kClocksApartS) return;
      plan_.shift_ns[key] = static_cast<int64_t>(std::llround(1e9 * (delay_s - laser_s)));
      plan_.note("the clock of %s is %.3f s %s the laser's: its stamps are moved", name.c_str(),
                 std::abs(delay_s - laser_s), delay_s > laser_s ? "behind" : "ahead of");
    };
    for (const auto& [name, topic] : survey_.topics) {
      const bool is_used = is_used_sensor(name) || plan_.uses_laser(name);
      if (is_used && topic.zero_stamps < topic.count) align(name, name, topic.least_delay_s);
    }
    const auto odometry = survey_.transform_delay_s.find({plan_.base_frame, plan_.odometry_parent});
    if (odometry != survey_.transform_delay_s.end()) align("tf", "tf", odometry->second);
  }

  bool is_used_sensor(const std::string& topic) const {
    return topic == plan_.odometry_topic || topic == plan_.imu_topic ||
           topic == plan_.truth_topic || plan_.uses_joints(topic);
  }

  void note_unused(const SurveyedTopic& topic) {
    const bool is_other =
        topic.use == Use::none || topic.use == Use::transforms || topic.use == Use::joints;
    if (is_other || plan_.uses_laser(topic.name) || is_used_sensor(topic.name)) return;
    plan_.note("%s (%s): %lld messages passed over", topic.name.c_str(), topic.type.c_str(),
               static_cast<long long>(topic.count));
  }

  // Pictures, commands, ...: of types that make no map.
  void note_others() {
    std::string text;
    for (const auto& [name, topic] : survey_.topics) {
      const bool is_other = topic.use == Use::none || topic.use == Use::joints;
      if (!is_other || plan_.uses_joints(name)) continue;
      text += (text.empty() ? "" : ", ") + name + " (" + topic.type + ")";
    }
    if (!text.empty()) plan_.notes.push_back("not used: " + text);
  }

  const RosSurvey& survey_;
  const RosOptions& options_;
  RosPlan plan_;
};

}  // namespace

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
