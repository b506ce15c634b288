#pragma once

#include <filesystem>

#include "common/trajectory.hpp"

namespace marco::files {

/// `time x y z qx qy qz qw`, time in seconds with 6 decimals, exactly the microseconds it was.
/// @throws std::runtime_error naming the path when it cannot be written.
void write_tum(const std::filesystem::path& path, const Trajectory& trajectory);

/// Reads that, and `time x y theta` too; `#` starts a comment.
/// @throws std::invalid_argument naming file and line where a line holds anything else, also nan.
Trajectory read_tum(const std::filesystem::path& path);

}  // namespace marco::files
