#pragma once

#include <filesystem>
#include <memory>

#include "recordings/sample_reader.hpp"

namespace marco::files {

/// CARMEN logs, old (FLASER, RLASER) and new (ROBOTLASER1, ROBOTLASER2).
///
/// Each laser line gives an OdometrySample at the scan's own stamp (the line's robot pose) and then
/// the LaserScan; ODOM lines are passed by, since their clock and frame need not be the laser's.
/// The stamp is ipc_time; stamps that step backwards are kept and counted. Old lines do not say how
/// far the laser saw nor how its beams lie: the largest range of the log, if met again and again,
/// is taken for "no return", and beams for spread over 180 degrees (401 beams: 100). Each such
/// assumption is a note of the report.
/// @throws std::invalid_argument naming file and remedy when there is no laser line in it.
std::unique_ptr<SampleReader> open_carmen(const std::filesystem::path& path);

}  // namespace marco::files
