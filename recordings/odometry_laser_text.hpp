#pragma once

#include <filesystem>
#include <memory>

#include "recordings/sample_reader.hpp"

namespace marco::files {

/// Text logs of lines `Odometry x y theta` and `Laser n r1 .. rn`, without stamps. Assumed, and
/// noted in the report: 0.1 s per scan, beams over 180 degrees, the pile at the top of the ranges
/// as "no return".
/// @throws std::invalid_argument naming file and remedy when the file has no laser line.
std::unique_ptr<SampleReader> open_odometry_laser_text(const std::filesystem::path& path);

}  // namespace marco::files
