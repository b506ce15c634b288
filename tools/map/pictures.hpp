#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "common/grid_map.hpp"
#include "common/line_map.hpp"
#include "common/triangle_mesh.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/picture_order.hpp"

namespace marco {

/// map.png: the grid with the paths: odometry blue, estimate red, truth green where known. Odometry
/// is aligned with the estimate by its first pose, truth by the best fit.
PictureOrder map_picture(const std::filesystem::path& path, const GridMap& map, const MapJob& job);

/// Pictures as thesis A's figures 6.1-6.4: lines.png, the plan in green with the covariance
/// ellipses of its ends (3 sigma) and the paths; lines_3d.png, the walls standing up, with the
/// robot and its paths.
std::vector<PictureOrder> line_pictures(const std::filesystem::path& folder,
                                        const GridMap& map,
                                        const LineMap& lines,
                                        const MapJob& job);

/// model.png. A laser that panned saw all walls of a room: the view is from above, without the
/// ceiling. One that only nodded saw the sides that face the robot: the view is from behind the
/// robot.
PictureOrder model_picture(const std::filesystem::path& path,
                           TriangleMesh model,
                           const MapJob& job);

/// One picture per loop closure, 000.png, 001.png ... in the report's order: the points of the
/// older keyframe, and those of the newer one before and after the closure.
std::vector<PictureOrder> loop_pictures(const std::filesystem::path& folder, const MapJob& job);

}  // namespace marco
