#pragma once

#include <filesystem>
#include <string>

#include "slam/localization/mapping_session.hpp"

namespace marco::slam {

/// Reads map.marco of a folder that `marco map` or SAVE wrote.
/// @throws std::invalid_argument naming the file and what is wrong with it.
SavedMap load_map_folder(const std::filesystem::path& folder);

/// Writes map.marco. @throws std::runtime_error naming the file.
void save_map_file(const std::filesystem::path& folder, const SavedMap& map);

/// Writes map.marco, map.pgm, map.yaml and trajectory.tum, making the folder.
/// @throws std::runtime_error naming the file.
void save_map_folder(const std::filesystem::path& folder,
                     const MappingSession& session,
                     const std::string& options);

/// A folder that a message names, below the one that the config allows.
/// @throws std::invalid_argument when it is absolute or leads out of it.
std::filesystem::path folder_below(const std::filesystem::path& allowed, const std::string& named);

}  // namespace marco::slam
