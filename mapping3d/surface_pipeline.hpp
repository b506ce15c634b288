#pragma once

#include <vector>

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/surface/planes.hpp"
#include "mapping3d/surface/simplify.hpp"
#include "mapping3d/surface/surface_model.hpp"

namespace marco::mapping3d {

struct SurfacePipelineOptions {
  SurfaceOptions surface;
  SimplifyOptions simplify;
  PlaneOptions planes;
  double plan_height_m = 1.2;  ///< where the floor plan is cut

  template <class Visitor>
  void visit(Visitor& v) {
    v("surface", surface);
    v("simplify", simplify);
    v("planes", planes);
    v("plan_height_m", plan_height_m);
  }
};

/// What a set of scenes becomes, in the world frame.
struct JoinedSurface {
  TriangleMesh mesh;                                     ///< the fused surface, whole
  std::vector<SurfacePlane> planes;                      ///< its flat parts, largest first
  Simplified simplified;                                 ///< the same surface in fewer triangles
  std::vector<std::vector<Eigen::Vector2d>> floor_plan;  ///< its cut at `plan_height_m`
};

/// The steps after fuse(): planes, then the simplification along them, then the floor plan.
/// @param mesh  as Mapper3d::model() gives it; an empty mesh has no planes and no plan
JoinedSurface derive_from_surface(TriangleMesh mesh, const SurfacePipelineOptions& options = {});

/// The whole pipeline: fuse -> find planes -> simplify -> cut the plan.
JoinedSurface join_surface(const std::vector<ScenePoints>& scenes,
                           const SurfacePipelineOptions& options = {});

}  // namespace marco::mapping3d
