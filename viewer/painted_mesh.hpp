#pragma once

#include "common/textured_mesh.hpp"

namespace marco::viewer {

/// A mesh with its picture as colours of its vertices, as the renderer draws it: edges longer than
/// `step_m` are halved, the same on both sides of each, until none is left; longer ones are left
/// where more than `most_triangles` would come of it beside those there were. A mesh without a
/// picture is passed on. Triangles share no vertices afterwards.
/// @throws std::invalid_argument when the picture is none.
TriangleMesh with_painted_vertices(const TexturedMesh& textured,
                                   double step_m = 0.04,
                                   double most_triangles = 4e6);

}  // namespace marco::viewer
