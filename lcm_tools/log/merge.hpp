#pragma once

#include <filesystem>
#include <vector>

#include "lcm_tools/log/select.hpp"

namespace marco::logs {

struct MergeInput {
  std::filesystem::path path;
  Duration shift;      ///< added to its event times
  std::string prefix;  ///< put before its channels
};

struct MergeResult {
  std::vector<int64_t> events;           ///< of each input
  std::vector<files::LogDamage> damage;  ///< of each input
};

/// Merges logs by event time and renumbers the events. At equal times the earlier input comes
/// first. Events that stand out of order inside one input stay so. Reads all inputs at once, each
/// through its window.
/// @throws std::invalid_argument when a prefix makes a channel longer than 63 bytes; as
/// EventLogReader and OutputFile.
MergeResult merge_logs(const std::vector<MergeInput>& inputs,
                       OutputFile& out,
                       const OnProgress& on_progress);

}  // namespace marco::logs
