#pragma once

#include <map>
#include <string>
#include <vector>

#include "drivers/devices/survey.hpp"

namespace marco::drivers::devices {

/// File name to its text: a configuration for each device that was found, and robot.procman, which
/// starts them, SLAM, logger and page. Empty when no device was found.
/// @param folder  where the files will be, absolute. @param mapping  mapping.procman, absolute.
/// @throws std::invalid_argument for a path that holds a quote or a backslash.
std::map<std::string, std::string> robot_files(const std::vector<PortReport>& reports,
                                               const std::string& folder,
                                               const std::string& mapping);

}  // namespace marco::drivers::devices
