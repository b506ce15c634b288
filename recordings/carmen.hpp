#pragma once

#include <filesystem>
#include <memory>

#include "recordings/sample_reader.hpp"

namespace marco::files {

/// CARMEN logs, old (FLASER, RLASER) and new (ROBOTLASER1, ROBOTLASER2).
///
/// Each laser line gives an OdometrySample at the scan's own stamp (the line's robot pose) and then
/// the LaserScan. ODOM lines are skipped: their clock and frame need not be the laser's. The stamp
/// is ipc_time; stamps that step backwards are kept and counted. Old lines tell neither the range
/// of the laser nor the bearings of its beams: the largest range that the log repeats counts as "no
/// return", and beams are spread over 180 degrees (401 beams: over 100). Each assumption is a note
/// of the report.
/// @throws std::invalid_argument naming file and remedy when the file has no laser line.
std::unique_ptr<SampleReader> open_carmen(const std::filesystem::path& path);

}  // namespace marco::files
