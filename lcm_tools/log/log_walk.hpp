#pragma once

#include <filesystem>
#include <functional>

#include "lcm_tools/log/select.hpp"
#include "lcm_tools/log/types.hpp"

namespace marco::logs {

/// Which events of which log an export is about.
struct WalkInput {
  std::filesystem::path path;
  TimeRange range;
  ChannelChoice channels;
};

/// An event with its message decoded, where that is possible.
struct DecodedEvent {
  const files::LogEventHead& head;
  std::span<const uint8_t> bytes;
  int structure = -1;  ///< of Types::schema(); -1: the type is not known, or the message is broken
  const lcm_schema::Tree& tree;  ///< of a structure >= 0
};

struct WalkResult {
  int64_t events = 0;       ///< chosen ones
  int64_t undecodable = 0;  ///< of these, without a tree
  files::LogDamage damage;
};

/// Calls `visit` for each chosen event in the order of the file.
WalkResult walk_log(WalkInput& input,
                    const Types& types,
                    const std::function<void(const DecodedEvent&)>& visit,
                    const OnProgress& on_progress);

}  // namespace marco::logs
