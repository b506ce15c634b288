#pragma once

#include <filesystem>
#include <memory>

#include "recordings/sample_reader.hpp"

namespace marco::files {

/// The scan files of the two theses, numbers only, told apart by their counts:
///  - thesis A (CVSWalls::ReadLaserData): a scan is 133 pairs x y [m] in the robot's frame, then
///  the
///    odometry x y [cm] and theta [rad];
///  - thesis B (get_ang_dist, get_movimientos): a sweep is 361 pairs bearing [deg] range [mm], then
///  the
///    displacement [mm] and turn [deg] of the base before it, tilt and pan [deg].
/// A last sweep of B that repeats the one before to the last digit (its reader's while(!feof) wrote
/// such files back) is dropped. No stamps: 0.1 s a scan is assumed.
/// @throws std::invalid_argument naming file and what was found.
std::unique_ptr<SampleReader> open_thesis_file(const std::filesystem::path& path);

/// Whether a file is text of numbers whose count fits one of the two.
bool is_thesis_file(const std::filesystem::path& path);

}  // namespace marco::files
