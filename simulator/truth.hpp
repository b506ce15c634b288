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

/// The distance of a map's occupied cells (>= 60 %) to the nearest true surface at the laser's
/// height. Half a cell's diagonal of it is the map's resolution.
/// @param world_from_map  e.g. from the best fit of the path
SurfaceError map_error(const GridMap& map,
                       const RayCaster& world,
                       const Pose2& world_from_map,
                       double laser_height_m);

/// The distance of a model's surface to the nearest true surface, at points spread evenly over all
/// triangles (one each 4 cm2, at least one a triangle). The search ends at 1 m.
SurfaceError model_error(const TriangleMesh& model,
                         const RayCaster& world,
                         const Pose3& world_from_model);

}  // namespace marco::sim
