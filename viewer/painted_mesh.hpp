#pragma once

#include "common/textured_mesh.hpp"

namespace marco::viewer {

/// Bakes the texture into vertex colours, which the renderer draws: edges longer than `step_m` are
/// halved, equally on both sides, as long as that adds at most `most_triangles`. A mesh without a
/// picture is returned unchanged. Triangles share no vertices afterwards.
/// @throws std::invalid_argument when the picture cannot be decoded.
TriangleMesh with_painted_vertices(const TexturedMesh& textured,
                                   double step_m = 0.04,
                                   double most_triangles = 4e6);

}  // namespace marco::viewer
