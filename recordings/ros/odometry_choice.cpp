#include "recordings/ros/sensor_choice.hpp"

#include <tuple>

#include "lcm_tools/base/check.hpp"

namespace marco::ros {
namespace {

class OdometryChoice {
 public:
  OdometryChoice(const RosSurvey& survey, const RosOptions& options, const SurveyedTopic& laser)
      : survey_(survey), options_(options), laser_(laser), mounts_(survey.tree) {}

  void choose(RosPlan& plan) const {
    if (options_.odometry != "none") choose_source(plan);
    choose_base(plan);
  }

 private:
  void choose_source(RosPlan& plan) const {
    const SurveyedTopic* topic = best_topic();
    const FrameEdge* edge = best_edge();
    if (!options_.odometry.empty() && options_.odometry != "tf") {
      const auto named = survey_.topics.find(options_.odometry);
      require(
          named != survey_.topics.end() && named->second.use == Use::odometry,
          "ros.odometry: no nav_msgs/Odometry on " + options_.odometry + "; " + survey_.contents());
      topic = &named->second;
      edge = nullptr;
    }
    if (options_.odometry == "tf") topic = nullptr;
    // A topic that never moves is worth less than a transform that does.
    const bool stands = topic != nullptr && topic->way_m == 0.0 && topic->turned_rad == 0.0;
    if (topic != nullptr && !(stands && edge != nullptr)) {
      plan.odometry_topic = topic->name;
      plan.note("odometry %s: %s in %s, %.1f m", topic->name.c_str(),
                name_or_none(topic->child_frame_id), name_or_none(topic->frame_id), topic->way_m);
    } else if (edge != nullptr) {
      plan.odometry_parent = edge->parent;
      plan.base_frame = edge->child;
      plan.note("odometry from tf: %s in %s", edge->child.c_str(), edge->parent.c_str());
    } else {
      choose_wheels(plan);
    }
  }

  void choose_wheels(RosPlan& plan) const {
    const auto wheels = wheel_joints(survey_);
    if (!wheels) return plan.note("no odometry: the path comes from scans alone");
    const std::string names = wheels->left + " and " + wheels->right + " of " + wheels->topic;
    if (options_.wheel_radius_m > 0.0 && options_.wheel_track_m > 0.0) {
      plan.wheels = wheels;
      return plan.note("odometry from the wheels %s", names.c_str());
    }
    plan.note(
        "no odometry: the path comes from scans alone; ros.wheel_radius_m and ros.wheel_track_m "
        "turn the wheels %s into odometry",
        names.c_str());
  }

  const SurveyedTopic* best_topic() const {
    const SurveyedTopic* best = nullptr;
    const auto merit = [&](const SurveyedTopic& topic) {
      return std::tuple(mounts_.is_on_robot(topic.child_frame_id, laser_.frame_id),
                        has(topic.name, {"odom"}), topic.way_m > 0.0, topic.count);
    };
    for (const auto& [name, topic] : survey_.topics) {
      if (topic.use != Use::odometry || topic.count < 2 || name == options_.truth) continue;
      if (names_truth(name) || is_map_frame(topic.frame_id)) continue;
      if (best == nullptr || merit(topic) > merit(*best)) best = &topic;
    }
    return best;
  }

  const FrameEdge* best_edge() const {
    const FrameEdge* best = nullptr;
    const auto merit = [&](const FrameEdge& edge) {
      return std::tuple(mounts_.is_on_robot(edge.child, laser_.frame_id),
                        has(edge.parent, {"odom"}), edge.count);
    };
    for (const FrameEdge* edge : survey_.tree.edges()) {
      if (edge->is_static || !has(edge->parent, {"odom"}) || names_truth(edge->child)) continue;
      if (best == nullptr || merit(*edge) > merit(*best)) best = edge;
    }
    return best;
  }

  void choose_base(RosPlan& plan) const {
    const auto odometry = survey_.topics.find(plan.odometry_topic);
    if (!options_.base_frame.empty()) {
      require(survey_.tree.contains(options_.base_frame),
              "ros.base_frame: there is no frame " + options_.base_frame + " in tf");
      plan.base_frame = options_.base_frame;
    } else if (odometry != survey_.topics.end() &&
               mounts_.is_on_robot(odometry->second.child_frame_id, laser_.frame_id)) {
      plan.base_frame = odometry->second.child_frame_id;
    } else if (!mounts_.is_on_robot(plan.base_frame, laser_.frame_id)) {
      plan.base_frame = mounts_.highest_on_robot(laser_.frame_id);
    }
  }

  const RosSurvey& survey_;
  const RosOptions& options_;
  const SurveyedTopic& laser_;
  SensorMounts mounts_;
};

}  // namespace

void choose_odometry(const RosSurvey& survey,
                     const RosOptions& options,
                     const SurveyedTopic& laser,
                     RosPlan& plan) {
  OdometryChoice(survey, options, laser).choose(plan);
}

}  // namespace marco::ros
