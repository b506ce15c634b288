#pragma once

#include "lcm_tools/log/log_walk.hpp"

namespace marco::logs {

struct McapResult {
  WalkResult walk;
  uint64_t messages = 0;
  std::size_t topics = 0;
  int64_t grids_left_out = 0;  ///< maps too large to be drawn; their tiles are there
};

/// Writes an MCAP file: every message that decodes as JSON with its type's JSON Schema, on a topic
/// with the channel's name, at the event's time; and beside it, on CHANNEL/NAME, what Foxglove can
/// draw of it (FoxgloveTranslator). Messages of types that are not known are left out and counted.
McapResult export_mcap(WalkInput& input,
                       const Types& types,
                       OutputFile& out,
                       const OnProgress& on_progress);

}  // namespace marco::logs
