#pragma once

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/surface/planes.hpp"

namespace marco::mapping3d {

struct SimplifyOptions {
  double max_error_m = 0.01;  ///< of either mesh from the other, sampled
  double snap_share = 0.5;    ///< part of it by which vertices may move onto a plane
  double sample_m2 = 2e-4;    ///< area of a sample when that is checked; edges are, too
  int rounds = 4;             ///< attempts, each half as bold, of what is not yet within

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_error_m", max_error_m, kPositive);
    v("snap_share", snap_share, Limits{0.0, 0.9});
    v("sample_m2", sample_m2, kPositive);
    v("rounds", rounds, Limits{1, 20});
  }
};

struct Simplified {
  enum class Status { nothing, within_bound, beyond_bound };

  Status status = Status::nothing;
  TriangleMesh mesh;
  double there_m = 0.0;       ///< largest sampled distance, the original from the simplified
  double back_m = 0.0;        ///< and the simplified from the original
  double beyond = 0.0;        ///< part of the samples beyond `max_error_m`, of the worse way
  std::size_t as_it_was = 0;  ///< triangles that no round could spare
};

/// Fewer triangles: what lies on one of `planes` but for its noise is laid on it, then edges
/// collapse by quadrics (Garland and Heckbert, SIGGRAPH 1997; libmeshoptimizer), so that flat walls
/// become large triangles. The library's error is a mean, so both meshes are sampled against each
/// other: triangles of the simplified that lie farther than `max_error_m` from the original are
/// taken back, and those of the original that are left uncovered are simplified by themselves with
/// half the error, with the triangles about them, so that no seam gapes; what the last round leaves
/// stays as it was. So all samples lie within the bound: `beyond_bound` is said only of a mesh
/// whose triangles are so large that samples of them miss each other.
/// @param planes of this mesh; none: nothing is moved
Simplified simplify(const TriangleMesh& mesh,
                    const std::vector<SurfacePlane>& planes = {},
                    const SimplifyOptions& options = {});

}  // namespace marco::mapping3d
