#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mapping3d/surface/planes.hpp"
#include "mapping3d/surface/simplify.hpp"
#include "mapping3d/surface/surface_model.hpp"

namespace marco {

struct JoinedSurfaceOptions {
  mapping3d::SurfaceOptions surface;
  mapping3d::SimplifyOptions simplify;
  mapping3d::PlaneOptions planes;
  double plan_height_m = 1.2;  ///< where the floor plan is cut

  template <class Visitor>
  void visit(Visitor& v) {
    v("surface", surface);
    v("simplify", simplify);
    v("planes", planes);
    v("plan_height_m", plan_height_m);
  }
};

struct JoinedSurface {
  TriangleMesh mesh;                      ///< world frame
  TriangleMesh simplified;                ///< the same surface in fewer triangles
  std::map<std::string, double> figures;  ///< for the report, by name with unit
};

/// One surface from all scenes, and into `folder`: model.ply (all of it), model.glb and model.obj
/// (simplified), planes.json, floor_plan.svg. Of no surface nothing is written.
JoinedSurface write_joined_surface(const std::filesystem::path& folder,
                                   const std::vector<mapping3d::ScenePoints>& scenes,
                                   const JoinedSurfaceOptions& options);

}  // namespace marco
