#pragma once

#include <filesystem>
#include <string>

namespace marco::files {

/// Why a file or folder cannot be read: "there is no such file or folder", "permission denied:
/// ...";
/// "" when it can.
std::string why_not_readable(const std::filesystem::path& path);

/// @throws std::invalid_argument "PATH: why" unless it can be opened for reading.
void require_readable(const std::filesystem::path& path);

}  // namespace marco::files
