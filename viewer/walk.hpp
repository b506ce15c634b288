#pragma once

#include <string>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "viewer/camera.hpp"

namespace marco::viewer {

/// The motion per unit of the robot's commands (thesis B, ch. 2.4, 2.5 and app. C).
struct WalkOptions {
  double forward_unit_m = 0.057;
  double turn_unit_deg = 2.35;
  double tilt_unit_deg = 3.4;
  double pan_unit_deg = 21.8;
  double tilt_min_deg = -20.0;
  double tilt_max_deg = 45.0;
  double eye_height_m = 0.9;

  template <class Visitor>
  void visit(Visitor& v) {
    v("forward_unit_m", forward_unit_m, kPositive);
    v("turn_unit_deg", turn_unit_deg, kPositive);
    v("tilt_unit_deg", tilt_unit_deg, kPositive);
    v("pan_unit_deg", pan_unit_deg, kPositive);
    v("tilt_min_deg", tilt_min_deg, Limits{-90.0, 0.0});
    v("tilt_max_deg", tilt_max_deg, Limits{0.0, 89.0});
    v("eye_height_m", eye_height_m, kPositive);
  }
};

/// One of the robot's commands: a forward, r back, i left, d right, each by units; e tilt and g pan
/// to a position in units: of the tilt from its lower end, of the pan from straight ahead.
struct WalkCommand {
  char letter = 'a';
  int units = 1;
};

/// Commands separated by spaces or newlines, "a10 i5 g2"; # starts a comment.
/// @throws std::invalid_argument naming the first word that is not a command.
std::vector<WalkCommand> parse_walk(const std::string& script);

/// A virtual robot with the motion units of the real one, to show the robot's view of a model.
/// Walls do not stop it.
class Walk {
 public:
  /// @throws std::invalid_argument when an option is out of its limits.
  explicit Walk(const Pose2& world_from_robot, double floor_m = 0.0, WalkOptions options = {});

  void apply(const WalkCommand& command);
  /// One unit of a key: a r i d as the commands, e E tilt up and down, g G pan left and right.
  /// @returns false for any other key.
  bool press(char key);

  const Pose2& world_from_robot() const { return world_from_robot_; }
  double tilt_rad() const { return tilt_rad_; }
  double pan_rad() const { return pan_rad_; }
  /// The robot's camera, with a vertical field of view of 80 deg.
  Camera camera() const;

 private:
  WalkOptions options_;
  Pose2 world_from_robot_;
  double floor_m_;
  double tilt_rad_ = 0.0;
  double pan_rad_ = 0.0;
};

}  // namespace marco::viewer
