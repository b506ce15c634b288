#pragma once

#include <initializer_list>
#include <optional>
#include <string>

#include "recordings/ros/transform_tree.hpp"

namespace marco::ros {

/// A joint between the robot and a laser, as a transform that moves.
struct Joint {
  std::string parent, child;  ///< frames
};

/// Whether a name holds one of the words, in capitals or not.
bool has(const std::string& name, std::initializer_list<const char*> words);

/// What simulators and motion capture publish as odometry.
bool names_truth(const std::string& name);

/// Another mapper's or localizer's result jumps, and is no odometry.
bool is_map_frame(const std::string& frame);

/// How sensors are fixed to a robot, by its frames.
class SensorMounts {
 public:
  /// @param tree  must outlive it
  explicit SensorMounts(const TransformTree& tree) : tree_(tree) {}

  /// The first moving transform above a sensor that is a joint of the robot.
  std::optional<Joint> joint_above(const std::string& frame) const;
  /// By transforms that do not move, but for one joint.
  bool is_on_robot(const std::string& base, const std::string& sensor) const;
  /// The highest of the frames above a sensor that belong to its robot; "" none.
  std::string highest_on_robot(const std::string& frame) const;

 private:
  bool is_fixed_to(const std::string& a, const std::string& b) const;

  const TransformTree& tree_;
};

}  // namespace marco::ros
