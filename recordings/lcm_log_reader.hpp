#pragma once

#include <filesystem>
#include <memory>

#include "recordings/foreign.hpp"
#include "recordings/sample_reader.hpp"

namespace marco {

/// LCM event logs, ours and other people's, as samples in the order of the log.
///
/// Our own channels are decoded as they are, others by `table`. The log is read twice: first to
/// learn its channels and how their clocks run. Where a channel's stamps differ from the laser's by
/// more than half a second beyond what the event times explain, its samples are moved to the
/// laser's clock by event time, with a note in the report; so where the clocks drift apart. A
/// foreign laser without SENSOR_INFO is assumed at the turning centre, looking ahead; of several
/// only the first is used. Damaged stretches are skipped (files::EventLogReader) and counted.
/// @throws std::invalid_argument naming file and remedy when the log holds no laser scan.
std::unique_ptr<files::SampleReader> open_lcm_log(const std::filesystem::path& path,
                                                  const ForeignTable& table = {});

}  // namespace marco
