#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/devices/survey.hpp"

namespace marco::drivers::devices {

/// How high the plane of a laser, "laser" or "laser_2", is above the floor [m]; nothing: not known.
using LaserHeight = std::function<std::optional<double>(const std::string& laser)>;

/// File name to its text: a configuration for each device that was found, and robot.procman, which
/// starts them, SLAM, logger and page. Empty when no device was found.
/// @param folder  where the files will be, absolute. @param mapping  mapping.procman, absolute.
/// @throws std::invalid_argument for a path that holds a quote or a backslash.
std::map<std::string, std::string> robot_files(const std::vector<PortReport>& reports,
                                               const std::string& folder,
                                               const std::string& mapping,
                                               const LaserHeight& height_m);

}  // namespace marco::drivers::devices
