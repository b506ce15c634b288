#pragma once

#include <filesystem>
#include <string>

namespace marco::web {

/// A snapshot whose model and photographs are data: URLs instead of names of files: pictures as
/// JPEG of at most 1024 pixels a side. A picture that cannot be read is left out.
/// @param snapshot  what snapshot_json(folder) gave
/// @throws std::invalid_argument when the model cannot be read.
std::string inline_files(const std::string& snapshot, const std::filesystem::path& folder);

}  // namespace marco::web
