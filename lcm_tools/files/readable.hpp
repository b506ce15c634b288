#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace marco::files {

/// Why a file or folder cannot be read: "there is no such file or folder", "permission denied:
/// ...", "it is a pipe, not a file" (which may wait for ever) or a device (which may never end); ""
/// when it can.
std::string why_not_readable(const std::filesystem::path& path);

/// @throws std::invalid_argument "PATH: why" unless it can be opened for reading.
void require_readable(const std::filesystem::path& path);

/// The same, opened. @throws std::invalid_argument likewise
std::ifstream open_readable(const std::filesystem::path& path);

/// Where the file continues behind a hole: `offset` itself where there is none, the file's size
/// where nothing follows.
int64_t next_data(int file, int64_t offset);

/// The first bytes of a file, `most` of a longer one; "" of what is none or cannot be read.
std::string first_bytes(const std::filesystem::path& path, std::size_t most);

}  // namespace marco::files
