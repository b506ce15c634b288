#pragma once

#include <vector>

#include "common/triangle_mesh.hpp"
#include "common/utime.hpp"
#include "mapping3d/scene.hpp"
#include "marco/mesh_t.hpp"
#include "marco/scene_t.hpp"

namespace marco::mapping3d {

/// A scene in messages of whole rows, each below 300 kB.
std::vector<scene_t> scene_messages(const Scene& scene);

/// A mesh in tiles below 300 kB, each complete in itself; a mesh of nothing is one empty tile.
/// @param mesh with normals
std::vector<mesh_t> mesh_messages(const TriangleMesh& mesh, Utime utime, int64_t revision);

}  // namespace marco::mapping3d
