#pragma once

#include <filesystem>

#include "slam/grid/occupancy_grid.hpp"
#include "slam/localization/saved_map.hpp"

namespace marco::slam {

/// Reads map.marco of a folder that `marco map` or SAVE wrote.
/// @throws std::invalid_argument naming the file and what is wrong with it.
SavedMap load_map_folder(const std::filesystem::path& folder);

/// Writes map.marco. @throws std::runtime_error naming the file.
void save_map_file(const std::filesystem::path& folder, const SavedMap& map);

/// Writes map.marco, the map's picture, map.yaml and trajectory.tum into a folder that exists.
/// @throws std::runtime_error naming the file.
void write_map_files(const std::filesystem::path& folder,
                     const SavedMap& map,
                     const OccupancyGridOptions& drawing,
                     const std::string& picture = "map.pgm");

/// The same for SAVE, while others may read the folder: it changes as a whole
/// (files::OutputFolder), its picture is numbered (map_1.pgm ...), and the one before stays for
/// programs that have just read the yaml.
/// @throws std::runtime_error naming the file; then the folder is as it was.
void save_map_folder(const std::filesystem::path& folder,
                     const SavedMap& map,
                     const OccupancyGridOptions& drawing);

}  // namespace marco::slam
