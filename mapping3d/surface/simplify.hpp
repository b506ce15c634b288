#pragma once

#include "common/options.hpp"
#include "common/triangle_mesh.hpp"

namespace marco::mapping3d {

struct SimplifyOptions {
  double max_error_m = 0.01;  ///< of either mesh from the other, sampled
  double sample_m2 = 1e-3;    ///< area of a sample when that is checked
  int rounds = 8;             ///< attempts, each more careful

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_error_m", max_error_m, kPositive);
    v("sample_m2", sample_m2, kPositive);
    v("rounds", rounds, Limits{1, 20});
  }
};

struct Simplified {
  enum class Status { within_bound, unchanged };

  Status status = Status::unchanged;
  TriangleMesh mesh;
  double there_m = 0.0;  ///< largest sampled distance, the original from the simplified
  double back_m = 0.0;   ///< and the simplified from the original
};

/// Fewer triangles: edges collapse by quadrics (Garland and Heckbert, SIGGRAPH 1997;
/// libmeshoptimizer), vertices stay where they are, flat walls become large triangles. The
/// library's error is a mean: here both meshes are sampled against each other, and the collapse
/// repeated with a smaller bound until every sample lies within `max_error_m`. When no round
/// reaches that, the mesh comes back unchanged and says so.
Simplified simplify(const TriangleMesh& mesh, const SimplifyOptions& options = {});

}  // namespace marco::mapping3d
