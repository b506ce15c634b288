#pragma once

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/surface/planes.hpp"

namespace marco::mapping3d {

struct SimplifyOptions {
  double max_error_m = 0.01;  ///< largest sampled distance between both meshes, either way
  double snap_share = 0.5;    ///< part of it by which a vertex may move onto a plane
  double sample_m2 = 2e-4;    ///< area per sample of the check
  int rounds = 4;             ///< attempts on what is beyond the bound, each with half the error

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_error_m", max_error_m, kPositive,
      "Largest distance between the simplified model and the full one. Less for more triangles.");
  }
};

struct Simplified {
  enum class Status { nothing, within_bound, beyond_bound };

  Status status = Status::nothing;
  TriangleMesh mesh;
  double there_m = 0.0;       ///< largest sampled distance from the original to the simplified ...
  double back_m = 0.0;        ///< ... and back
  double beyond = 0.0;        ///< part of the samples beyond `max_error_m`, the larger of both ways
  std::size_t as_it_was = 0;  ///< triangles that no round could simplify
};

/// Mesh simplification with a bound: snaps vertices to `planes`, then collapses edges by quadric
/// errors (Garland and Heckbert, SIGGRAPH 1997; libmeshoptimizer), so that flat walls become large
/// triangles. The library bounds a mean error only, so both meshes are sampled against each other:
/// simplified triangles beyond `max_error_m` are removed, and the uncovered part of the original is
/// simplified again, together with its neighbours, with half the error; what remains after the last
/// round is kept. All samples then lie within the bound; `beyond_bound` can only occur for
/// triangles so large that the samples of both meshes miss each other.
/// @param planes of this mesh; without planes nothing is snapped
Simplified simplify(const TriangleMesh& mesh,
                    const std::vector<SurfacePlane>& planes = {},
                    const SimplifyOptions& options = {});

}  // namespace marco::mapping3d
