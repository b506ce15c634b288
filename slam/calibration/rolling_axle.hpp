#pragma once

#include "slam/calibration/motion_samples.hpp"

namespace marco::slam {

/// Where the axle is by the odometry alone: the line on which nothing slides sideways. Poses that
/// are not the axle's own, because the robot's frame is elsewhere or looks elsewhere, seem to slide
/// as they turn or drive. How far to its side the poses are, no sliding tells.
/// @returns the pose of the axle in the robot's frame, as OdometryCalibration's; nothing changed
/// where nothing slides, and where the robot does so (mecanum wheels).
OdometryCalibration axle_of(const std::vector<LaserMotion>& motions, const OdometryTravel& travel);

}  // namespace marco::slam
