#pragma once

#include <vector>

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/surface/planes.hpp"
#include "mapping3d/surface/simplify.hpp"
#include "mapping3d/surface/surface_model.hpp"

namespace marco::mapping3d {

struct SurfacePipelineOptions {
  SurfaceOptions surface;
  SimplifyOptions simplify;
  PlaneOptions planes;

  template <class Visitor>
  void visit(Visitor& v) {
    surface.visit(v);
    v("simplify", simplify);
    v("planes", planes);
  }
};

/// What is derived from the fused surface of all scenes, world frame.
struct JoinedSurface {
  std::vector<SurfacePlane> planes;  ///< its flat parts, largest first
  Simplified simplified;             ///< the same surface in fewer triangles
};

/// The surface pipeline: fuse() -> find planes -> simplify along them. Its first step is
/// Mapper3d::model(), which live and offline share.
/// @param mesh  the fused surface; an empty one has no planes
JoinedSurface join_surface(const TriangleMesh& mesh, const SurfacePipelineOptions& options = {});

}  // namespace marco::mapping3d
