#pragma once

#include <array>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// Limits of thesis B's rule [m]: all distances from a polygon's first vertex lie between them.
struct ThesisMeshOptions {
  double min_edge_m = 0.005;
  double max_edge_m = 0.200;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_edge_m", min_edge_m, kNotNegative);
    v("max_edge_m", max_edge_m, kPositive);
  }
};

/// Quads (v_ij, v_i,j+1, v_i+1,j+1, v_i+1,j) by thesis B's rule (ch. 4.3), as indices row * columns
/// + column; none at missing beams.
std::vector<std::array<uint32_t, 4>> thesis_quads(const ScenePoints& scene,
                                                  const ThesisMeshOptions& options = {});

/// Each such quad as two triangles (v_ij, v_i,j+1, v_i+1,j+1) and (v_ij, v_i+1,j+1, v_i+1,j), each
/// judged by itself.
std::vector<std::array<uint32_t, 3>> thesis_triangles(const ScenePoints& scene,
                                                      const ThesisMeshOptions& options = {});

}  // namespace marco::mapping3d
