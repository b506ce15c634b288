#pragma once

#include <filesystem>
#include <optional>

#include "slam/calibration/self_calibration.hpp"
#include "tools/map/map_job.hpp"

namespace marco {

/// What the laser that makes the path sits on the robot by: itself, or its pan-tilt; nullptr where
/// nobody says. The first level one, if there are several.
const SensorInfo* mount_of_laser(const MapJob& job);

/// What the drive says of that laser on the robot, odometry and gyroscope, by the path that
/// was mapped. Nothing where there is no such laser, or neither odometry nor gyroscope.
std::optional<slam::SelfCalibration> self_calibration_of(const MapJob& job);

/// calibration.toml of the drive and of the pan-tilt's sweeps, for --calibration; prints both, too.
/// @returns false, and writes nothing, where there is nothing to calibrate.
bool write_calibration(const std::filesystem::path& path, const MapJob& job);

}  // namespace marco
