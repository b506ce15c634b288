#include "recordings/ros/ros_plan.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"

namespace marco::ros {
namespace {

bool has(const std::string& name, std::initializer_list<const char*> words) {
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return lower.find(word) != std::string::npos; });
}

// What simulators and motion capture publish as odometry.
bool names_truth(const std::string& name) {
  return has(name, {"truth", "gazebo", "vicon", "mocap", "optitrack", "/gt"});
}

// Another mapper's or localizer's result jumps, and is no odometry.
bool is_map_frame(const std::string& frame) { return has(frame, {"map", "world"}); }

// "LIDAR" for the first laser, "LIDAR_BACK_SCAN" for /back_scan.
std::string channel_of(const std::string& topic, bool is_first) {
  if (is_first) return channels::kLidar;
  std::string name = "LIDAR_";
  for (const char letter : topic.substr(topic.front() == '/' ? 1 : 0)) {
    const auto byte = static_cast<unsigned char>(letter);
    name += std::isalnum(byte) != 0 ? static_cast<char>(std::toupper(byte)) : '_';
  }
  return name;
}

double sweep_rad(const SurveyedTopic& laser) {
  return std::abs(static_cast<double>(laser.first_scan.angle_increment)) *
         static_cast<double>(laser.beams);
}

class Planner {
 public:
  Planner(const RosSurvey& survey, const RosOptions& options)
      : survey_(survey), tree_(survey.tree), options_(options) {}

  RosPlan plan() {
    const std::vector<const SurveyedTopic*> lasers = lasers_by_merit();
    choose_odometry(*lasers.front());
    choose_base(*lasers.front());
    for (const SurveyedTopic* laser : lasers) add_laser(*laser);
    choose_imu();
    plan_.truth_topic = options_.truth;
    require(options_.truth.empty() || survey_.topics.contains(options_.truth),
            "ros.truth: there is no topic " + options_.truth + "; " + contents());
    align_clocks();
    for (const auto& [name, topic] : survey_.topics) note_unused(topic);
    note_others();
    return std::move(plan_);
  }

 private:
  [[gnu::format(printf, 2, 3)]] void note(const char* format, ...) {
    std::array<char, 400> text{};
    va_list values;
    va_start(values, format);
    std::vsnprintf(text.data(), text.size(), format, values);
    va_end(values);
    plan_.notes.emplace_back(text.data());
  }

  std::string contents() const {
    std::string text = "it holds";
    for (const auto& [name, topic] : survey_.topics) {
      text += (text == "it holds" ? " " : ", ") + name + " (" + topic.type + ")";
    }
    return text == "it holds" ? "it holds no messages" : text;
  }

  static bool is_laser(const SurveyedTopic& topic) {
    constexpr int64_t kFewest = 2;
    return topic.count >= kFewest && topic.beams >= 2 &&
           (topic.use == Use::scan || (topic.use == Use::cloud && topic.is_flat));
  }

  // The one that sees most first: it moves with the robot, and its place is known.
  std::vector<const SurveyedTopic*> lasers_by_merit() const {
    std::vector<const SurveyedTopic*> lasers;
    for (const auto& [name, topic] : survey_.topics) {
      if (is_laser(topic) && (options_.laser.empty() || options_.laser == name)) {
        lasers.push_back(&topic);
      }
    }
    require(!lasers.empty(), options_.laser.empty()
                                 ? "no laser: " + contents()
                                 : "ros.laser: no scans on " + options_.laser + "; " + contents());
    const auto merit = [this](const SurveyedTopic* laser) {
      return std::tuple(laser->use == Use::scan, !joint_above(laser->frame_id).has_value(),
                        sweep_rad(*laser) > 1.9 * std::numbers::pi, laser->count);
    };
    std::stable_sort(lasers.begin(), lasers.end(),
                     [&](const auto* a, const auto* b) { return merit(a) > merit(b); });
    return lasers;
  }

  // The first moving transform above a sensor that is a joint of the robot.
  std::optional<Joint> joint_above(const std::string& frame) const {
    for (const FrameEdge* edge : tree_.way_up(frame)) {
      if (!edge->moves()) continue;
      constexpr double kJointMovesM = 0.05;
      if (edge->moved_m > kJointMovesM || edge->turned_rad < 0.01 || is_odometry(*edge)) return {};
      return Joint{edge->parent, edge->child, false};
    }
    return std::nullopt;
  }

  static bool is_odometry(const FrameEdge& edge) {
    return has(edge.parent, {"odom"}) || is_map_frame(edge.parent);
  }

  bool is_fixed_to(const std::string& a, const std::string& b) const {
    return a == b || tree_.fixed_pose(a, b).has_value();
  }

  bool is_on_robot(const std::string& base, const std::string& sensor) const {
    if (base.empty() || sensor.empty()) return false;
    if (is_fixed_to(base, sensor)) return true;
    const auto joint = joint_above(sensor);
    return joint && is_fixed_to(base, joint->parent);
  }

  void choose_odometry(const SurveyedTopic& laser) {
    if (options_.odometry == "none") return;
    const SurveyedTopic* topic = best_odometry_topic(laser);
    const FrameEdge* edge = best_odometry_edge(laser);
    if (!options_.odometry.empty() && options_.odometry != "tf") {
      const auto named = survey_.topics.find(options_.odometry);
      require(named != survey_.topics.end() && named->second.use == Use::odometry,
              "ros.odometry: no nav_msgs/Odometry on " + options_.odometry + "; " + contents());
      topic = &named->second;
      edge = nullptr;
    }
    if (options_.odometry == "tf") topic = nullptr;
    // A topic that never moves is worth less than a transform that does.
    const bool stands = topic != nullptr && topic->way_m == 0.0 && topic->turned_rad == 0.0;
    if (topic != nullptr && !(stands && edge != nullptr)) {
      plan_.odometry_topic = topic->name;
      note("odometry %s: %s in %s, %.1f m", topic->name.c_str(), or_unnamed(topic->child_frame_id),
           or_unnamed(topic->frame_id), topic->way_m);
    } else if (edge != nullptr) {
      plan_.odometry_parent = edge->parent;
      plan_.base_frame = edge->child;
      note("odometry from tf: %s in %s", edge->child.c_str(), edge->parent.c_str());
    } else {
      note("no odometry: the path comes from scans alone");
    }
  }

  static const char* or_unnamed(const std::string& frame) {
    return frame.empty() ? "(no frame)" : frame.c_str();
  }

  const SurveyedTopic* best_odometry_topic(const SurveyedTopic& laser) const {
    const SurveyedTopic* best = nullptr;
    const auto merit = [&](const SurveyedTopic& topic) {
      return std::tuple(!names_truth(topic.name), !is_map_frame(topic.frame_id),
                        is_on_robot(topic.child_frame_id, laser.frame_id),
                        has(topic.name, {"odom"}), topic.way_m > 0.0, topic.count);
    };
    for (const auto& [name, topic] : survey_.topics) {
      if (topic.use != Use::odometry || topic.count < 2 || name == options_.truth) continue;
      if (names_truth(name) || is_map_frame(topic.frame_id)) continue;
      if (best == nullptr || merit(topic) > merit(*best)) best = &topic;
    }
    return best;
  }

  const FrameEdge* best_odometry_edge(const SurveyedTopic& laser) const {
    const FrameEdge* best = nullptr;
    const auto merit = [&](const FrameEdge& edge) {
      return std::tuple(is_on_robot(edge.child, laser.frame_id), has(edge.parent, {"odom"}),
                        edge.count);
    };
    for (const FrameEdge* edge : tree_.edges()) {
      if (edge->is_static || !has(edge->parent, {"odom"}) || names_truth(edge->child)) continue;
      if (best == nullptr || merit(*edge) > merit(*best)) best = edge;
    }
    return best;
  }

  void choose_base(const SurveyedTopic& laser) {
    const auto odometry = survey_.topics.find(plan_.odometry_topic);
    if (!options_.base_frame.empty()) {
      require(tree_.contains(options_.base_frame),
              "ros.base_frame: there is no frame " + options_.base_frame + " in tf");
      plan_.base_frame = options_.base_frame;
    } else if (odometry != survey_.topics.end() &&
               is_on_robot(odometry->second.child_frame_id, laser.frame_id)) {
      plan_.base_frame = odometry->second.child_frame_id;
    } else if (!is_on_robot(plan_.base_frame, laser.frame_id)) {
      plan_.base_frame = highest_on_robot(laser.frame_id);
    }
  }

  // Of the frames above the laser the robot's own, or else the highest.
  std::string highest_on_robot(const std::string& frame) const {
    std::string highest;
    for (const FrameEdge* edge : tree_.way_up(frame)) {
      if (is_odometry(*edge)) break;
      if (!is_on_robot(edge->parent, frame)) break;
      highest = edge->parent;
    }
    return highest;
  }

  void add_laser(const SurveyedTopic& topic) {
    LaserPlan laser;
    laser.topic = topic.name;
    laser.frame = topic.frame_id;
    laser.is_cloud = topic.use == Use::cloud;
    laser.info.channel = channel_of(topic.name, plan_.lasers.empty());
    if (!place(laser)) return;
    describe(topic, laser);
    plan_.lasers.push_back(std::move(laser));
  }

  // False: another laser is mapped with.
  bool place(LaserPlan& laser) {
    const bool is_first = plan_.lasers.empty();
    const bool has_fixed = std::any_of(
        plan_.lasers.begin(), plan_.lasers.end(),
        [](const LaserPlan& other) { return other.info.mount == SensorInfo::Mount::robot; });
    const auto fixed = plan_.base_frame.empty() ? std::optional<Pose3>()
                                                : tree_.fixed_pose(plan_.base_frame, laser.frame);
    if (fixed && has_fixed) {
      // Transforms are seldom right to the degree that two lasers of one map need.
      note("laser %s is passed over: one fixed laser is mapped with; ros.laser chooses another",
           laser.topic.c_str());
      return false;
    }
    if (fixed) {
      laser.info.parent_from_sensor = *fixed;
    } else if (!place_on_joint(laser)) {
      if (!is_first) {
        note("laser %s is passed over: no transform tells where %s is", laser.topic.c_str(),
             or_unnamed(laser.frame));
        return false;
      }
      note(
          "laser %s: no transform tells where %s is; it is assumed at the turning centre, looking "
          "ahead",
          laser.topic.c_str(), or_unnamed(laser.frame));
      return true;
    }
    note_place(laser);
    return true;
  }

  void note_place(const LaserPlan& laser) {
    const Pose3& pose = laser.info.parent_from_sensor;
    const Eigen::Vector3d at_m = pose.translation();
    const bool upside_down = pose.linear()(2, 2) < 0.0;
    note("laser %s in %s: %.3f %.3f %.3f m, %.1f deg%s on %s (tf)", laser.topic.c_str(),
         laser.frame.c_str(), at_m.x(), at_m.y(), at_m.z(), rad_to_deg(flatten(pose).theta_rad),
         upside_down ? ", upside down," : "",
         laser.info.mount == SensorInfo::Mount::pantilt ? "its joint" : plan_.base_frame.c_str());
  }

  // A laser that nods or pans, on a robot whose other frames are fixed.
  bool place_on_joint(LaserPlan& laser) {
    const auto joint = joint_above(laser.frame);
    if (!joint || plan_.base_frame.empty()) return false;
    const auto base = tree_.fixed_pose(plan_.base_frame, joint->parent);
    const auto plate = tree_.fixed_pose(joint->child, laser.frame);
    const FrameEdge* edge = tree_.above(joint->child);
    if (!base || !plate || edge == nullptr) return false;
    if (plan_.pantilt && plan_.joints.front().child != joint->child) return false;
    laser.info.mount = SensorInfo::Mount::pantilt;
    laser.info.parent_from_sensor = *plate;
    SensorInfo pantilt;
    pantilt.channel = channels::kPanTiltState;
    pantilt.parent_from_sensor = *base;
    pantilt.parent_from_sensor.translation() =
        *base * Eigen::Vector3d(edge->parent_from_child.translation());
    plan_.pantilt = pantilt;
    plan_.joints = {*joint};
    note("laser %s moves on the robot: the joint from %s to %s is its pan-tilt",
         laser.topic.c_str(), joint->parent.c_str(), joint->child.c_str());
    return true;
  }

  void describe(const SurveyedTopic& topic, LaserPlan& laser) {
    const LaserScanMessage& scan = topic.first_scan;
    laser.info.range_min_m = std::max(0.0, static_cast<double>(scan.range_min));
    if (std::isfinite(scan.range_max) && scan.range_max > scan.range_min) {
      laser.info.range_max_m = static_cast<double>(scan.range_max);
    }
    laser.scan_channel = laser.info.channel;
    if (laser.is_cloud) return;
    const double told_s = static_cast<double>(scan.time_increment) *
                          static_cast<double>(topic.beams > 0 ? topic.beams - 1 : 0);
    const bool sees_round = sweep_rad(topic) > 1.6 * std::numbers::pi;
    const bool fits = told_s > 0.0 && (topic.period_s <= 0.0 || told_s < 1.3 * topic.period_s);
    laser.tells_beam_times = sees_round && told_s > 0.0;
    if (laser.tells_beam_times) laser.scan_channel = channels::raw_channel_of(laser.info.channel);
    if (fits) {
      laser.duration_s = told_s;
      laser.info.scan_duration_s = told_s;
    } else if (told_s > 0.0 && !sees_round) {
      note(
          "%s: its beams would take %.3f s, and scans come every %.3f s: taken as measured at once",
          topic.name.c_str(), told_s, topic.period_s);
    }
  }

  void choose_imu() {
    for (const auto& [name, topic] : survey_.topics) {
      if (topic.use != Use::imu || topic.count < 2) continue;
      const auto current = survey_.topics.find(plan_.imu_topic);
      if (current != survey_.topics.end() && current->second.count >= topic.count) continue;
      plan_.imu_topic = name;
      const auto placed = plan_.base_frame.empty()
                              ? std::nullopt
                              : tree_.fixed_pose(plan_.base_frame, topic.frame_id);
      plan_.base_from_imu = placed.value_or(Pose3::Identity());
    }
    if (plan_.imu_topic.empty()) return;
    // Two turns a second: no robot that maps does it.
    constexpr double kFastestRadPerS = 4.0 * std::numbers::pi;
    const double fastest = survey_.topics.at(plan_.imu_topic).fastest_turn;
    const bool in_degrees = fastest > kFastestRadPerS;
    if (in_degrees) plan_.rad_per_imu_unit = deg_to_rad(1.0);
    note("gyroscope %s%s", plan_.imu_topic.c_str(),
         in_degrees ? ": its rates are degrees a second, against the message's definition" : "");
  }

  // Computers whose clocks disagree: by the delay from stamp to recorder, which else is alike.
  void align_clocks() {
    constexpr double kClocksApartS = 0.5;
    const double laser_s = survey_.topics.at(plan_.lasers.front().topic).least_delay_s;
    const auto align = [&](const std::string& key, const std::string& name, double delay_s) {
      if (std::abs(delay_s - laser_s) < kClocksApartS) return;
      plan_.shift_ns[key] = static_cast<int64_t>(std::llround(1e9 * (delay_s - laser_s)));
      note("the clock of %s is %.3f s %s the laser's: its stamps are moved", name.c_str(),
           std::abs(delay_s - laser_s), delay_s > laser_s ? "behind" : "ahead of");
    };
    for (const auto& [name, topic] : survey_.topics) {
      const bool is_used = name == plan_.odometry_topic || name == plan_.imu_topic ||
                           name == plan_.truth_topic || is_used_laser(name);
      if (is_used && topic.zero_stamps < topic.count) align(name, name, topic.least_delay_s);
    }
    const auto odometry = survey_.transform_delay_s.find({plan_.base_frame, plan_.odometry_parent});
    if (odometry != survey_.transform_delay_s.end()) align("tf", "tf", odometry->second);
  }

  bool is_used_laser(const std::string& topic) const {
    return std::any_of(plan_.lasers.begin(), plan_.lasers.end(),
                       [&](const LaserPlan& laser) { return laser.topic == topic; });
  }

  void note_unused(const SurveyedTopic& topic) {
    if (topic.use == Use::none || topic.use == Use::transforms || is_used_laser(topic.name)) return;
    if (topic.name == plan_.odometry_topic || topic.name == plan_.imu_topic) return;
    if (topic.name == plan_.truth_topic) return;
    note("%s (%s): %lld messages passed over", topic.name.c_str(), topic.type.c_str(),
         static_cast<long long>(topic.count));
  }

  // Pictures, joints, commands, ...: of types that make no map.
  void note_others() {
    std::string text;
    for (const auto& [name, topic] : survey_.topics) {
      if (topic.use != Use::none) continue;
      text += (text.empty() ? "" : ", ") + name + " (" + topic.type + ")";
    }
    if (!text.empty()) plan_.notes.push_back("not used: " + text);
  }

  const RosSurvey& survey_;
  const TransformTree& tree_;
  const RosOptions& options_;
  RosPlan plan_;
};

}  // namespace

RosPlan plan_of(const RosSurvey& survey, const RosOptions& options) {
  return Planner(survey, options).plan();
}

}  // namespace marco::ros
