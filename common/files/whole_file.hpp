#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace marco::files {

/// Writes a file as a whole: under a temporary name beside it, renamed when every byte is on the
/// disk, so that nobody ever reads half of it. @throws std::runtime_error naming the path and why
/// (disk full, ...).
void write_whole_file(const std::filesystem::path& path, std::string_view content);

/// @throws std::invalid_argument naming the path when it cannot be read.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace marco::files
