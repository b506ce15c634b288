#pragma once

#include "common/laser_scan.hpp"
#include "recordings/ros/messages.hpp"
#include "recordings/ros/ros_plan.hpp"

namespace marco::ros {

/// The angle from beam to beam [rad]. Where the told increment is zero, or `beams` of them do not
/// fit in a turn, as of some drivers, the first and the last angle decide.
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
