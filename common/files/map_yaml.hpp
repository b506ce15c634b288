#pragma once

#include <filesystem>

#include "common/grid_map.hpp"

namespace marco::files {

/// Writes `folder`/map.pgm and `folder`/map.yaml in the convention of ROS map_server: the picture's
/// first row is the largest y; 0 = occupied, 254 = free, 205 = unknown, probabilities in between.
/// @throws std::runtime_error naming the path when it cannot be written.
void write_map(const std::filesystem::path& folder, const GridMap& map);

/// Reads a map.yaml and the picture it names (binary PGM), of ours or of map_server.
/// @throws std::invalid_argument naming file and what was wrong.
GridMap read_map(const std::filesystem::path& yaml_path);

}  // namespace marco::files
