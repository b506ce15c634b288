#pragma once

#include "common/options.hpp"
#include "common/triangle_mesh.hpp"
#include "mapping3d/surface/planes.hpp"

namespace marco::mapping3d {

struct SimplifyOptions {
  double max_error_m = 0.01;      ///< of either mesh from the other, sampled
  double allowed_beyond = 0.001;  ///< part of the samples that may lie farther: lone scraps
  double snap_share = 0.5;        ///< part of it by which vertices may move onto a plane
  double sample_m2 = 1e-3;        ///< area of a sample when that is checked
  int rounds = 4;                 ///< attempts, each half as bold

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_error_m", max_error_m, kPositive);
    v("allowed_beyond", allowed_beyond, Limits{0.0, 1.0});
    v("snap_share", snap_share, Limits{0.0, 0.9});
    v("sample_m2", sample_m2, kPositive);
    v("rounds", rounds, Limits{1, 20});
  }
};

struct Simplified {
  enum class Status { nothing, within_bound, beyond_bound };

  Status status = Status::nothing;
  TriangleMesh mesh;
  double there_m = 0.0;  ///< largest sampled distance, the original from the simplified
  double back_m = 0.0;   ///< and the simplified from the original
  double beyond = 0.0;   ///< part of the samples beyond `max_error_m`, of the worse way
};

/// Fewer triangles: what lies on one of `planes` but for its noise is laid on it, then edges
/// collapse by quadrics (Garland and Heckbert, SIGGRAPH 1997; libmeshoptimizer), so that flat walls
/// become large triangles. The library's error is a mean: here both meshes are sampled against each
/// other, and the collapse repeated with half its bound until all samples but `allowed_beyond` lie
/// within `max_error_m`; when the last round does not reach that, it says `beyond_bound` and how
/// far.
/// @param planes of this mesh; none: nothing is moved
Simplified simplify(const TriangleMesh& mesh,
                    const std::vector<SurfacePlane>& planes = {},
                    const SimplifyOptions& options = {});

}  // namespace marco::mapping3d
