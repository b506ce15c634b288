#pragma once

#include <filesystem>
#include <memory>

#include "recordings/sample_reader.hpp"

namespace marco::files {

/// The scan files of the two theses: numbers only, distinguished by their count.
///  - Thesis A (CVSWalls::ReadLaserData): a scan is 133 pairs x y [m] in the robot's frame, then
///    the odometry x y [cm] and theta [rad].
///  - Thesis B (get_ang_dist, get_movimientos): a sweep is 361 pairs bearing [deg] range [mm], then
///    the displacement [mm] and turn [deg] of the base before the sweep, tilt and pan [deg]. A last
///    sweep that equals the one before is dropped: B's own reader wrote such files back.
/// There are no stamps: assuming 0.1 s per scan.
/// @throws std::invalid_argument naming the file and what was found.
std::unique_ptr<SampleReader> open_thesis_file(const std::filesystem::path& path);

/// Whether the file holds nothing but numbers, and their count fits one of the two.
bool is_thesis_file(const std::filesystem::path& path);

}  // namespace marco::files
