#pragma once

#include <filesystem>
#include <memory>

#include "recordings/sample_reader.hpp"

namespace marco::files {

/// Text logs of lines `Odometry x y theta` and `Laser n r1 .. rn`, without stamps: 0.1 s a scan is
/// assumed, which is a note of the report, as are beams over 180 degrees and the no-return range.
/// @throws std::invalid_argument naming file and remedy when there is no laser line in it.
std::unique_ptr<SampleReader> open_odometry_laser_text(const std::filesystem::path& path);

}  // namespace marco::files
