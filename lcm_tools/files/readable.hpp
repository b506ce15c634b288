#pragma once

#include <filesystem>
#include <string>

namespace marco::files {

/// What keeps a file or folder from being read: "there is no such file or folder", "permission
/// denied: ..."; "" when nothing does.
std::string why_not_readable(const std::filesystem::path& path);

/// @throws std::invalid_argument "PATH: why" unless it can be opened for reading.
void require_readable(const std::filesystem::path& path);

}  // namespace marco::files
