#pragma once

#include <filesystem>
#include <functional>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/log/channel_choice.hpp"
#include "lcm_tools/log/moment.hpp"
#include "lcm_tools/log/output_file.hpp"

namespace marco::logs {

/// Called now and then with the part done, 0..1.
using OnProgress = std::function<void(double)>;

struct SelectResult {
  int64_t events = 0;
  int64_t kept = 0;
  int64_t kept_bytes = 0;
  files::LogDamage damage;
};

/// Copies the events of `range` on the chosen channels to `out`, byte by byte as they are: number
/// and time stay. Damage is left out. Runs of kept events are copied in the kernel.
/// @throws std::invalid_argument or std::runtime_error as EventLogReader and OutputFile.
SelectResult select_events(const std::filesystem::path& in,
                           OutputFile& out,
                           const TimeRange& range,
                           ChannelChoice& channels,
                           const OnProgress& on_progress);

}  // namespace marco::logs
