#pragma once

#include "lcm_tools/log/extensions.hpp"

namespace marco::logs {

/// What Marco adds to the log commands: import of recordings, CARMEN export, Foxglove topics in
/// MCAP files, the orders to robots, and advice for files that are not an LCM log.
Extensions marco_extensions();

}  // namespace marco::logs
