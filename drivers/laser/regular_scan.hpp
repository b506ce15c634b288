#pragma once

#include "common/laser_scan.hpp"

namespace marco::drivers {

/// The scan as planar_lidar_t can carry it: one first bearing, one step, no times of the beams.
/// Irregular bearings go to the nearest place of a regular fan of as many beams, from the first
/// bearing to the last. Of two beams at one place the nearer to it stays; a place without a beam is
/// 0: no return. A beam is moved by half a step at most.
LaserScan regular_scan(const LaserScan& scan);

}  // namespace marco::drivers
