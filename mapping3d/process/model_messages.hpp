#pragma once

#include <functional>
#include <vector>

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/utime.hpp"
#include "mapping3d/scene.hpp"
#include "marco/mesh_t.hpp"
#include "marco/scene_t.hpp"

namespace marco::mapping3d {

/// A scene in messages of whole rows, each below 300 kB.
std::vector<scene_t> scene_messages(const Scene& scene);

/// Hands out a mesh in tiles below 300 kB, each complete in itself; a mesh of nothing is one empty
/// tile. One tile at a time, since a model may be large.
/// @param mesh with normals
void for_each_tile(const TriangleMesh& mesh,
                   Utime utime,
                   int64_t revision,
                   const std::function<void(const mesh_t&)>& take);

}  // namespace marco::mapping3d
