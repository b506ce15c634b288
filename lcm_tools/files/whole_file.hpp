#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "lcm_tools/files/output_file.hpp"

namespace marco::files {

/// Writes a file atomically, as OutputFile does: no reader sees half of it.
/// @throws std::runtime_error naming the path and why (disk full, ...).
void write_whole_file(const std::filesystem::path& path,
                      std::string_view content,
                      Appears appears = Appears::when_whole);

/// @throws std::invalid_argument naming the path, and why it cannot be read: it is longer than
/// `most_bytes`, no file, ...
std::string read_whole_file(const std::filesystem::path& path, int64_t most_bytes = INT64_MAX);

}  // namespace marco::files
