#pragma once

#include <vector>

#include "common/grid_map.hpp"
#include "common/pose3.hpp"
#include "common/triangle_mesh.hpp"
#include "simulator/ray_caster.hpp"

namespace marco::sim {

struct SurfaceError {
  std::size_t count = 0;
  double rms_m = 0.0;
  double p95_m = 0.0;
  double p99_m = 0.0;
};

/// How far a map's occupied cells (>= 60 %) lie from the nearest true surface, at the laser's
/// height.
/// @param world_from_map  e.g. of the best fit of the path; half a cell's diagonal is the map's own
/// grain
SurfaceError map_error(const GridMap& map,
                       const RayCaster& world,
                       const Pose2& world_from_map,
                       double laser_height_m);

/// How far a model's surface lies from the nearest true surface: all triangles, points spread
/// evenly over their area (one each 4 cm2, at least one a triangle), nothing cut off but the search
/// at 1 m.
SurfaceError model_error(const TriangleMesh& model,
                         const RayCaster& world,
                         const Pose3& world_from_model);

}  // namespace marco::sim
