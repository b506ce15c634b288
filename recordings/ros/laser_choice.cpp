#include "recordings/ros/sensor_choice.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <tuple>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "recordings/ros/ros_scan.hpp"

namespace marco::ros {
namespace {

// "LIDAR" for the first laser, "LIDAR_BACK_SCAN" for /back_scan.
std::string channel_of_laser(const std::string& topic, bool is_first) {
  if (is_first) return channels::kLidar;
  std::string name = "LIDAR_";
  for (const char letter : topic.substr(topic.front() == '/' ? 1 : 0)) {
    const auto byte = static_cast<unsigned char>(letter);
    name += std::isalnum(byte) != 0 ? static_cast<char>(std::toupper(byte)) : '_';
  }
  return name;
}

double sweep_rad(const SurveyedTopic& laser) {
  return std::abs(beam_step_rad(laser.first_scan, laser.beams)) * static_cast<double>(laser.beams);
}

bool is_laser(const SurveyedTopic& topic) {
  constexpr int64_t kFewest = 2;
  return topic.count >= kFewest && topic.beams >= 2 &&
         (topic.use == Use::scan || (topic.use == Use::cloud && topic.is_flat));
}

bool moves_on_robot(const RosSurvey& survey, const SurveyedTopic& laser) {
  return SensorMounts(survey.tree).joint_above(laser.frame_id) || pantilt_joints(survey, laser);
}

class LaserPlanner {
 public:
  LaserPlanner(const RosSurvey& survey, const SurveyedTopic& topic, RosPlan& plan)
      : tree_(survey.tree), topic_(topic), joints_(pantilt_joints(survey, topic)), plan_(plan) {}

  void add() {
    laser_.topic = topic_.name;
    laser_.frame = topic_.frame_id;
    laser_.is_cloud = topic_.use == Use::cloud;
    laser_.bearings = topic_.bearings;
    laser_.info.channel = channel_of_laser(topic_.name, plan_.lasers.empty());
    if (!place()) return;
    tell_ranges();
    tell_times();
    plan_.lasers.push_back(std::move(laser_));
  }

 private:
  // False: another laser is mapped with.
  bool place() {
    const bool is_first = plan_.lasers.empty();
    const bool has_fixed = std::any_of(
        plan_.lasers.begin(), plan_.lasers.end(),
        [](const LaserPlan& other) { return other.info.mount == SensorInfo::Mount::robot; });
    const auto fixed = plan_.base_frame.empty() ? std::optional<Pose3>()
                                                : tree_.fixed_pose(plan_.base_frame, laser_.frame);
    if (place_on_joint() || place_on_joint_states(fixed.value_or(Pose3::Identity()))) {
      note_place();
      return true;
    }
    if (fixed && has_fixed) {
      // Transforms are seldom right to the degree that two lasers of one map need.
      plan_.note(
          "laser %s is ignored: Marco maps with one fixed laser; the line ros.laser = \"%s\" in "
          "NAME.marco.toml next to the recording NAME, or in a file for --foreign, selects this "
          "one",
          laser_.topic.c_str(), laser_.topic.c_str());
      return false;
    }
    if (!fixed && !is_first) {
      plan_.note("laser %s is ignored: no transform to %s", laser_.topic.c_str(),
                 name_or_none(laser_.frame));
      return false;
    }
    if (!fixed) {
      plan_.note(
          "laser %s: no transform to %s; assuming it at the turning centre, looking "
          "ahead",
          laser_.topic.c_str(), name_or_none(laser_.frame));
      return true;
    }
    laser_.info.parent_from_sensor = *fixed;
    note_place();
    return true;
  }

  void note_place() {
    const Pose3& pose = laser_.info.parent_from_sensor;
    const Eigen::Vector3d at_m = pose.translation();
    const bool upside_down = pose.linear()(2, 2) < 0.0;
    plan_.note(
        "laser %s in %s: %.3f %.3f %.3f m, %.1f deg%s on %s (tf)", laser_.topic.c_str(),
        name_or_none(laser_.frame), at_m.x(), at_m.y(), at_m.z(),
        rad_to_deg(flatten(pose).theta_rad), upside_down ? ", upside down," : "",
        laser_.info.mount == SensorInfo::Mount::pantilt ? "its joint" : plan_.base_frame.c_str());
  }

  // A laser that nods or pans, on a robot whose other frames are fixed.
  bool place_on_joint() {
    const auto joint = SensorMounts(tree_).joint_above(laser_.frame);
    if (!joint || plan_.base_frame.empty()) return false;
    const auto base = tree_.fixed_pose(plan_.base_frame, joint->parent);
    const auto plate = tree_.fixed_pose(joint->child, laser_.frame);
    const FrameEdge* edge = tree_.above(joint->child);
    if (!base || !plate || edge == nullptr) return false;
    if (plan_.pantilt && (plan_.joints.empty() || plan_.joints.front().child != joint->child)) {
      return false;
    }
    const Eigen::Vector3d axis_m = *base * Eigen::Vector3d(edge->parent_from_child.translation());
    Pose3 axis = *base;
    axis.translation() = axis_m;
    set_pantilt(axis, *plate);
    plan_.joints = {*joint};
    plan_.note("laser %s moves on the robot: the joint from %s to %s is its pan-tilt",
               laser_.topic.c_str(), joint->parent.c_str(), joint->child.c_str());
    return true;
  }

  // The same where tf does not show the joint's motion.
  bool place_on_joint_states(const Pose3& base_from_laser) {
    if (!joints_ || plan_.pantilt) return false;
    Pose3 axis = Pose3::Identity(), plate = Pose3::Identity();
    axis.translation() = base_from_laser.translation();
    plate.linear() = base_from_laser.linear();
    set_pantilt(axis, plate);
    plan_.pantilt_joints = joints_;
    plan_.note(
        "laser %s moves on the robot: its pan-tilt is %s of %s, where positive tilt looks "
        "down",
        laser_.topic.c_str(),
        (joints_->pan + (joints_->pan.empty() || joints_->tilt.empty() ? "" : " and ") +
         joints_->tilt)
            .c_str(),
        joints_->topic.c_str());
    return true;
  }

  void set_pantilt(const Pose3& base_from_axis, const Pose3& plate_from_laser) {
    laser_.info.mount = SensorInfo::Mount::pantilt;
    laser_.info.parent_from_sensor = plate_from_laser;
    SensorInfo pantilt;
    pantilt.channel = channels::kPanTiltState;
    pantilt.parent_from_sensor = base_from_axis;
    plan_.pantilt = pantilt;
  }

  void tell_ranges() {
    const LaserScanMessage& scan = topic_.first_scan;
    laser_.info.range_min_m = std::max(0.0, static_cast<double>(scan.range_min));
    const auto told_m = static_cast<double>(scan.range_max);
    const bool is_told = std::isfinite(told_m) && scan.range_max > scan.range_min;
    if (is_told) laser_.info.range_max_m = told_m;
    // Below the told limit walls may pile up, too, where a robot stands.
    constexpr double kAtLimit = 0.95;
    const double pile_m = topic_.no_return_m;
    if (!is_told || pile_m < kAtLimit * told_m || pile_m >= told_m) return;
    laser_.info.range_max_m = pile_m;
    plan_.note("%s: ranges accumulate from %.2f m on: treated as no return", topic_.name.c_str(),
               pile_m);
  }

  void tell_times() {
    const LaserScanMessage& scan = topic_.first_scan;
    laser_.scan_channel = laser_.info.channel;
    if (laser_.is_cloud) return;
    const double told_s = static_cast<double>(scan.time_increment) *
                          static_cast<double>(topic_.beams > 0 ? topic_.beams - 1 : 0);
    const bool sees_round = sweep_rad(topic_) > 1.6 * std::numbers::pi;
    const bool fits = told_s > 0.0 && (topic_.period_s <= 0.0 || told_s < 1.3 * topic_.period_s);
    laser_.tells_beam_times = sees_round && told_s > 0.0;
    if (laser_.tells_beam_times) {
      laser_.scan_channel = channels::raw_channel_of(laser_.info.channel);
    }
    if (fits) {
      laser_.duration_s = told_s;
      laser_.info.scan_duration_s = told_s;
    } else if (told_s > 0.0 && !sees_round) {
      plan_.note(
          "%s: its beams would take %.3f s, but scans arrive every %.3f s: treated as measured "
          "simultaneously",
          topic_.name.c_str(), told_s, topic_.period_s);
    }
  }

  const TransformTree& tree_;
  const SurveyedTopic& topic_;
  const std::optional<PanTiltJoints> joints_;
  RosPlan& plan_;
  LaserPlan laser_;
};

}  // namespace

std::vector<const SurveyedTopic*> lasers_by_merit(const RosSurvey& survey,
                                                  const RosOptions& options) {
  std::vector<const SurveyedTopic*> lasers;
  for (const auto& [name, topic] : survey.topics) {
    if (is_laser(topic) && (options.laser.empty() || options.laser == name)) {
      lasers.push_back(&topic);
    }
  }
  require(!lasers.empty(), options.laser.empty() ? "no laser: " + survey.contents()
                                                 : "ros.laser: no scans on " + options.laser +
                                                       "; " + survey.contents());
  // The one that sees most first: it moves with the robot, and its place is known.
  const auto merit = [&survey](const SurveyedTopic* laser) {
    return std::tuple(laser->use == Use::scan, !moves_on_robot(survey, *laser),
                      sweep_rad(*laser) > 1.9 * std::numbers::pi, laser->count);
  };
  std::stable_sort(lasers.begin(), lasers.end(),
                   [&](const auto* a, const auto* b) { return merit(a) > merit(b); });
  return lasers;
}

void add_laser(const RosSurvey& survey, const SurveyedTopic& laser, RosPlan& plan) {
  LaserPlanner(survey, laser, plan).add();
}

}  // namespace marco::ros
