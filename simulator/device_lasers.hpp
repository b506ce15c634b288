#pragma once

#include <string>

#include "simulator/simulation_options.hpp"

namespace marco::sim {

/// Beams, bearings, times and ranges of a real laser, as its driver publishes them.
/// @param device  sick, hokuyo, rplidar, ld19, ydlidar_x4, tim561 or leuze. @throws
/// std::invalid_argument for another.
LaserOptions device_laser(const std::string& device);

}  // namespace marco::sim
