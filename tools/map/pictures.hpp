#pragma once

#include <filesystem>

#include "common/grid_map.hpp"
#include "common/triangle_mesh.hpp"
#include "common/wall.hpp"
#include "tools/map/map_job.hpp"

namespace marco {

/// map.png: the grid with the paths: odometry blue, estimate red, truth green where known. Odometry
/// and truth are laid on the estimate's frame (odometry by its first pose, truth by the best fit).
void draw_map_picture(const std::filesystem::path& path, const GridMap& map, const MapJob& job);

/// Pictures as thesis A's figures 6.1-6.4: lines.png, the plan in green with the covariance
/// ellipses of its ends (3 sigma) and the paths; lines_scan.png, one scan's points in blue with the
/// walls on them; lines_3d.png, the walls standing up, with the robot and its paths.
void draw_line_pictures(const std::filesystem::path& folder,
                        const GridMap& map,
                        const Walls& walls,
                        const MapJob& job);

/// model.png. A laser that panned saw its rooms from all sides: they are shown from above, ceiling
/// taken off. One that only nodded saw the sides that face the robot: they are shown from behind
/// it.
void draw_model_picture(const std::filesystem::path& path, TriangleMesh model, const MapJob& job);

}  // namespace marco
