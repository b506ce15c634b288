#pragma once

#include <optional>
#include <string>

#include "lcm_tools/log/commands.hpp"

namespace marco::logs {

/// What is in a recording that `marco map` reads and that is no LCM log: of ROS its topics, types,
/// counts, rates, span and clocks; of others their samples by kind.
/// @returns nothing for LCM logs, and for files that hold no recording.
std::optional<std::string> describe_recording(const std::string& path, Format format);

}  // namespace marco::logs
