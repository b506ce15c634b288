#pragma once

#include "lcm_tools/log/mcap_translator.hpp"

namespace marco::logs {

struct McapResult {
  WalkResult walk;
  uint64_t messages = 0;
  std::size_t topics = 0;
  std::string remark;  ///< McapTranslator::remark
};

/// Writes an MCAP file: every message that decodes as JSON with the JSON Schema of its type, on a
/// topic named like its channel, at the event time. A translator adds more topics. Messages of
/// unknown types are left out and counted.
/// @param make_translator may be empty
McapResult export_mcap(WalkInput& input,
                       const Types& types,
                       OutputFile& out,
                       const MakeMcapTranslator& make_translator,
                       const OnProgress& on_progress);

}  // namespace marco::logs
