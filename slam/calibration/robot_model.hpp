#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/pose2.hpp"

namespace marco::slam {

/// What two wheels counted in a short time. Of odometry given as poses: the ways of two virtual
/// wheels kCountedTrackM apart [m]; of wheel angles: [rad], and scales are radii [m].
struct WheelStep {
  double left = 0.0;
  double right = 0.0;
  double aside = 0.0;  ///< to the left; of a robot, or a frame on it, that does not roll ahead only
};

/// One motion, as wheels and laser saw it.
struct MotionSample {
  std::vector<WheelStep> wheels;  ///< one after another
  Pose2 laser_moved;              ///< the laser at the end, seen from its own pose at the begin
  Pose2 robot_from_axle;          ///< of the wheels, where the robot's frame is another
};

/// A differential drive with a laser on it.
struct RobotModel {
  double left_scale = 1.0;  ///< way of the left wheel [m] by what it counts
  double right_scale = 1.0;
  double track_m = 1.0;  ///< between the wheels
  Pose2 robot_from_laser;
};

/// How the axle moves, each step an arc.
Pose2 axle_motion(const std::vector<WheelStep>& wheels, const RobotModel& model);

/// The laser's motion less what the model expects of it: x, y [m] along the laser's axes, angle.
Eigen::Vector3d error_of(const MotionSample& sample, const RobotModel& model);

}  // namespace marco::slam
