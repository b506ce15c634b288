#pragma once

#include <filesystem>
#include <memory>

#include "recordings/foreign.hpp"
#include "recordings/sample_reader.hpp"

namespace marco {

/// LCM event logs, ours and other people's, as samples in the order of the log.
///
/// Our own channels are decoded as they are; any other by `table`. The log is read twice: first to
/// learn which channels there are and how their clocks run. Where a channel's stamps differ from
/// the laser's by more than half a second beyond what the log's event times say, its samples are
/// given stamps in the laser's clock, by event time; that is a note of the report. A foreign laser
/// without SENSOR_INFO is taken to sit at the turning centre and look ahead; of several such only
/// the first is used. Damage is skipped (files::EventLogReader) and counted.
/// @throws std::invalid_argument naming file and remedy when no laser scan can be read from it.
std::unique_ptr<files::SampleReader> open_lcm_log(const std::filesystem::path& path,
                                                  const ForeignTable& table = {});

}  // namespace marco
