#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "recordings/sample_reader.hpp"

namespace marco::files {

/// 3D scans of a laser that was tilted while the robot stood, as samples of such a robot: the
/// SensorInfo once, then for each row an OdometrySample (the scan's .pose, a start guess), a
/// PanTiltState and a LaserScan, 0.1 s apart. Three kinds, distinguished by their content:
///  - `*_tilt_ranges_mm.csv`: a line is a row: tilt [deg], then ranges [mm] each 0.5 deg from the
///    right;
///  - `*.3d` of uos: points x (right) y (up) z (ahead) [cm], left-handed, in the order of the
///    beams, row by row; those of other scanners are none of these;
///  - `scan_polar.csv`: line, tilt [deg], bearing [deg], range [m]; the tilt axis 0.340 m above the
///    floor and the laser 0.160 m above the axis.
/// `*.pose`: x y z [cm] and three Euler angles [deg], left-handed as .3d; without it a scan was
/// taken at the origin. Where a scan exists as .csv and .3d of one stem, the .csv is taken.
/// @param paths files or folders
/// @throws std::invalid_argument naming file and remedy when none of them can be read.
std::unique_ptr<SampleReader> open_tilted_scans(const std::vector<std::filesystem::path>& paths);

/// Whether a file looks like one of the three.
bool is_tilted_scan(const std::filesystem::path& path);

}  // namespace marco::files
