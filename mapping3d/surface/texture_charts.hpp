#pragma once

#include <array>
#include <vector>

#include "common/triangle_mesh.hpp"

namespace marco::mapping3d {

/// Where a mesh's triangles lie in an atlas.
struct TextureCharts {
  int width_px = 0;
  int height_px = 0;
  double texel_m = 0.0;                    ///< the size in use
  TriangleMesh mesh;                       ///< vertices doubled where charts meet
  std::vector<Eigen::Vector2f> places_px;  ///< of each vertex
};

/// Divides a mesh into charts (connected triangles with one main axis and no overlap) and packs
/// them on shelves, two texels apart. Texels grow from `texel_m` until the atlas is no larger than
/// `max_px` on either side. Memory: a bit for each texel of the largest chart, besides the meshes.
/// @throws std::invalid_argument where texels of any size do not help: there are too many charts
TextureCharts lay_out(const TriangleMesh& mesh, double texel_m, int max_px);

}  // namespace marco::mapping3d
