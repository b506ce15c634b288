#pragma once

#include "lcm_tools/process/command_line.hpp"

namespace marco::logs {

/// Adds `convert IN OUT`: any recording that Marco reads as an LCM log, a CARMEN log, a ROS 1 bag,
/// or an MCAP file for ROS 2, ROS 1 or a viewer. The format of IN follows from its content, that of
/// OUT from its ending or --format.
void add_convert(process::CommandLine& program);

}  // namespace marco::logs
