#pragma once

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/surface/planes.hpp"

namespace marco::mapping3d {

struct SimplifyOptions {
  double max_error_m = 0.01;  ///< largest sampled distance between both meshes, either way
  double snap_share = 0.5;    ///< part of it by which a vertex may move onto a plane
  double sample_m2 = 2e-4;    ///< area per sample of the check

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_error_m", max_error_m, kPositive,
      "Largest distance between the simplified model and the full one. Less for more triangles.");
  }
};

struct Simplified {
  TriangleMesh mesh;
  double there_m = 0.0;  ///< largest sampled distance from the original to the simplified ...
  double back_m = 0.0;   ///< ... and back
};

/// Mesh simplification with a bound: snaps vertices to `planes`, then moves vertices onto
/// neighbours, those first that have the least quadric error (Garland and Heckbert, SIGGRAPH 1997),
/// so that flat walls become large triangles. Each move is made only if it
/// - keeps the topology, so that nothing opens that was closed, no edge gets a third triangle and
///   nothing becomes double (CollapsingMesh);
/// - turns no triangle over;
/// - leaves vertices of a plane on it, and what is between them;
/// - keeps all samples of both meshes within `max_error_m` of the other mesh (SurfaceBound).
/// Vertices at the same place count as one, and are one afterwards. Where more than two triangles
/// meet in an edge, or surfaces in a vertex only, vertices stay.
/// @param planes of this mesh; without planes, or normals, nothing is snapped
Simplified simplify(const TriangleMesh& mesh,
                    const std::vector<SurfacePlane>& planes = {},
                    const SimplifyOptions& options = {});

}  // namespace marco::mapping3d
