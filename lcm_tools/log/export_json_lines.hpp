#pragma once

#include <string>

#include "lcm_tools/log/log_walk.hpp"

namespace marco::logs {

/// One JSON object a line: event, time_us, channel, type, message; where the type is not known or
/// the message broken, fingerprint and data (base64) instead of the last two. Byte arrays are
/// base64, too.
WalkResult export_json_lines(WalkInput& input,
                             const Types& types,
                             OutputFile& out,
                             const OnProgress& on_progress);

using lcm_schema::to_base64;

}  // namespace marco::logs
