#include "mapping3d/surface_pipeline.hpp"

namespace marco::mapping3d {

JoinedSurface join_surface(const TriangleMesh& mesh, const SurfacePipelineOptions& options) {
  validate(options, "joined_surface");
  JoinedSurface joined;
  if (mesh.triangles.empty()) return joined;
  joined.planes = find_planes(mesh, options.planes);
  joined.simplified = simplify(mesh, joined.planes, options.simplify);
  return joined;
}

}  // namespace marco::mapping3d
