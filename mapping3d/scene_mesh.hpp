#pragma once

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

struct SceneMeshOptions {
  double edge_factor = 6.0;    ///< longest edge as a multiple of the beams' distance at its range,
                               ///< which is about 80 deg of incidence ...
  double edge_floor_m = 0.03;  ///< ... but at least this, so that noise tears no hole ...
  double max_edge_m = 0.6;     ///< ... and at most this

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("edge_factor", edge_factor, kPositive,
               "Longest edge of a sweep's mesh, as a multiple of the beams' spacing there. More "
               "closes gaps, and bridges separate surfaces.");
    v.advanced("max_edge_m", max_edge_m, kPositive, "Longest edge of a sweep's mesh.");
  }
};

/// Mean angle between a beam and its neighbour in the next row and column, of a sample of some
/// hundred [rad]; 0 where no two returned.
float beam_spacing_rad(const ScenePoints& scene);

/// Beams processed at once: eight where the processor has AVX2. The mesh is the same bit for bit;
/// `four` exists for comparison.
enum class Lanes { as_many_as_there_are, four };

/// Meshes one scene: triangles with shared vertices between neighbouring beams, not across depth
/// edges (an edge's limit depends on range and incidence, the same for near and far walls) nor
/// missing beams. A quad is divided by its shorter diagonal; normals are weighted by area and point
/// to the sensor, from which triangles are counter-clockwise. Vertices are in the order of the
/// scene's points, triangles in that of its quads. One pass over the rows, O(points).
TriangleMesh mesh_scene(const ScenePoints& scene,
                        const SceneMeshOptions& options = {},
                        Lanes lanes = Lanes::as_many_as_there_are);

/// Appends `part` to `whole`.
void append_mesh(TriangleMesh& whole, const TriangleMesh& part);

}  // namespace marco::mapping3d
