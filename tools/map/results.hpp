#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/line_map.hpp"
#include "lcm_tools/files/output_folder.hpp"
#include "slam/localization/saved_map.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/self_correction.hpp"

namespace marco {

/// The folder that `marco map` writes. Committing it removes the results of an earlier run, also of
/// versions that wrote no list of them; whatever the command reads stays.
/// @param inputs  every file and folder that the command line names; of a folder with a map, the
/// map
std::unique_ptr<files::OutputFolder> open_results(const std::filesystem::path& out,
                                                  const std::vector<std::string>& inputs);

/// trajectory.tum and its companions.
void write_paths(const std::filesystem::path& out,
                 const MapJob& job,
                 const std::optional<SelfCorrection>& correction);

/// trajectory_session_N.tum: one per session, those of the saved map first.
void write_sessions(const std::filesystem::path& out, const slam::SavedMap& map);

/// lines.svg, lines.dxf and lines.json.
void write_lines(const std::filesystem::path& out, const LineMap& lines, const MapJob& job);

/// Whether two names are one folder.
bool same_folder(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace marco
