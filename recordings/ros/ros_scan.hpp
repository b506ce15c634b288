#pragma once

#include "common/laser_scan.hpp"
#include "recordings/ros/messages.hpp"
#include "recordings/ros/ros_plan.hpp"

namespace marco::ros {

/// From beam to beam [rad], of so many. Some drivers tell an increment of zero, or one that does
/// not fit in a turn: then the first and last angle count.
double beam_step_rad(const LaserScanMessage& message, std::size_t beams);

/// A message as a scan. Its bearings are those that the number of ranges and the increment give,
/// which need not end at angle_max.
/// @param options  turn and shift it
LaserScan to_scan(const LaserScanMessage& message,
                  const LaserPlan& laser,
                  const RosOptions& options);

/// A flat cloud as a scan: on the bearings of its laser where it has such, else one beam a point.
LaserScan to_scan(const CloudMessage& cloud, const LaserPlan& laser, const RosOptions& options);

}  // namespace marco::ros
