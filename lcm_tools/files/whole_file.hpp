#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "lcm_tools/files/output_file.hpp"

namespace marco::files {

/// Writes a file as a whole, as OutputFile does: nobody ever reads half of it.
/// @throws std::runtime_error naming the path and why (disk full, ...).
void write_whole_file(const std::filesystem::path& path,
                      std::string_view content,
                      Appears appears = Appears::when_whole);

/// Reads a file, after finishing what a killed command left half exchanged in its folder.
/// @throws std::invalid_argument naming the path, and why it cannot be read.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace marco::files
