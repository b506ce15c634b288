#pragma once

#include <filesystem>

#include "common/grid_map.hpp"
#include "common/triangle_mesh.hpp"
#include "tools/map/map_job.hpp"

namespace marco {

/// map.png: the grid with the paths: odometry blue, estimate red, truth green where known. Odometry
/// and truth are laid on the estimate's frame (odometry by its first pose, truth by the best fit).
void draw_map_picture(const std::filesystem::path& path, const GridMap& map, const MapJob& job);

/// model.png: the model from above, its ceiling taken off.
void draw_model_picture(const std::filesystem::path& path, TriangleMesh model);

}  // namespace marco
