#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/triangle_mesh.hpp"

namespace marco::mapping3d {

/// The same triangles with the vertices of a place as one, which has their mean normal and the
/// colour of one of them; nothing where no two vertices are at one place.
std::optional<TriangleMesh> welded(const TriangleMesh& mesh);

/// Triangles whose corners at the same place are the same vertex, the first of them.
std::vector<std::array<uint32_t, 3>> welded(const std::vector<std::array<uint32_t, 3>>& triangles,
                                            const std::vector<Eigen::Vector3f>& vertices_m);

}  // namespace marco::mapping3d
