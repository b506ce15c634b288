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

/// Text logs of lines `Odometry x y theta` and `Laser n r1 .. rn`, without stamps. Assumed, and
/// noted in the report: 0.1 s per scan, beams over 180 degrees, the pile at the top of the ranges
/// as "no return".
/// @throws std::invalid_argument naming file and remedy when the file has no laser line.
std::unique_ptr<SampleReader> open_odometry_laser_text(const std::filesystem::path& path);

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
