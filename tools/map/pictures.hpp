#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "common/grid_map.hpp"
#include "common/triangle_mesh.hpp"
#include "common/wall.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/picture_order.hpp"

namespace marco {

/// map.png: the grid with the paths: odometry blue, estimate red, truth green where known. Odometry
/// and truth are laid on the estimate's frame (odometry by its first pose, truth by the best fit).
PictureOrder map_picture(const std::filesystem::path& path, const GridMap& map, const MapJob& job);

/// Pictures as thesis A's figures 6.1-6.4: lines.png, the plan in green with the covariance
/// ellipses of its ends (3 sigma) and the paths; lines_3d.png, the walls standing up, with the
/// robot and its paths.
std::vector<PictureOrder> line_pictures(const std::filesystem::path& folder,
                                        const GridMap& map,
                                        const Walls& walls,
                                        const MapJob& job);

/// model.png. A laser that panned saw its rooms from all sides: they are shown from above, ceiling
/// taken off. One that only nodded saw the sides that face the robot: they are shown from behind
/// it.
PictureOrder model_picture(const std::filesystem::path& path,
                           TriangleMesh model,
                           const MapJob& job);

/// A picture a loop, 000.png, 001.png ... in the report's order: the older keyframe's points, and
/// the newer one's where it was believed to be before and where it was found to be.
std::vector<PictureOrder> loop_pictures(const std::filesystem::path& folder, const MapJob& job);

}  // namespace marco
