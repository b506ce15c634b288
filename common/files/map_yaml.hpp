#pragma once

#include <filesystem>
#include <string>

#include "common/grid_map.hpp"

namespace marco::files {

/// Writes `folder`/map.pgm and `folder`/map.yaml in the convention of ROS map_server: the picture's
/// first row is the largest y; 0 = occupied, 254 = free, 205 = unknown, probabilities in between.
/// @throws std::runtime_error naming the path when it cannot be written.
/// @param picture  its file name, written to the yaml
void write_map(const std::filesystem::path& folder,
               const GridMap& map,
               const std::string& picture = "map.pgm");

/// The name of the picture in `folder`/map.yaml; "" without such a file.
std::string picture_of_map(const std::filesystem::path& folder);

/// A new name for each picture of a map that is rewritten while others read it: map_1.pgm,
/// map_2.pgm ... A reader of the old yaml never finds a newer picture under its name.
std::string next_picture_name(const std::string& picture_before);

/// Reads a map.yaml and the picture it names (binary PGM), of ours or of map_server. The picture is
/// in the yaml's folder or below; no link points outside.
/// @throws std::invalid_argument naming file and what was wrong.
GridMap read_map(const std::filesystem::path& yaml_path);

}  // namespace marco::files
