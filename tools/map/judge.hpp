#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "common/grid_map.hpp"
#include "common/triangle_mesh.hpp"
#include "tools/map/map_job.hpp"

namespace marco {

/// Errors by name with unit, for the report; unknown ones are left out.
using Errors = std::map<std::string, double>;

/// Errors of the path against TRUE_POSE of the recording (after the best rigid fit).
Errors judge_path(const MapJob& job);

/// How well the map predicts the ranges of the scans that were held out.
Errors judge_held_out(const MapJob& job, const GridMap& map);

/// Errors of map and model against the simulator's world, aligned by the fit of the path.
/// @param world_file  see simulator/world.hpp
/// @throws std::runtime_error where this build has no simulator.
Errors judge_against_world(const MapJob& job,
                           const GridMap& map,
                           const TriangleMesh& model,
                           const std::filesystem::path& world_file);

}  // namespace marco
