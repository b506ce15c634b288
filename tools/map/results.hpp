#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/wall.hpp"
#include "lcm_tools/files/output_folder.hpp"
#include "tools/map/map_job.hpp"

namespace marco {

/// The folder that `marco map` writes. Results of an earlier run go when the new ones are
/// committed, also those of versions that left no list of them; whatever the command reads stays.
/// @param inputs  every file and folder that the command line names; of a folder with a map, the
/// map
std::unique_ptr<files::OutputFolder> open_results(const std::filesystem::path& out,
                                                  const std::vector<std::string>& inputs);

/// trajectory.tum and its companions.
void write_paths(const std::filesystem::path& out, const MapJob& job);

/// lines.svg, lines.dxf and lines.json.
void write_lines(const std::filesystem::path& out, const Walls& walls, const MapJob& job);

/// Whether two names mean the same folder.
bool same_folder(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace marco
