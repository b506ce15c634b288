#pragma once

#include <filesystem>

#include "common/triangle_mesh.hpp"

namespace marco::files {

/// Binary little-endian PLY: vertices (float x y z, normals and colours where the mesh has them),
/// faces.
/// @throws std::runtime_error naming the path when it cannot be written.
void write_ply(const std::filesystem::path& path, const TriangleMesh& mesh);

/// Reads any PLY, text or binary of either byte order: polygons as fans of triangles, normals and
/// colours where it has them; other elements and properties are ignored.
/// @throws std::invalid_argument naming file and what was wrong.
TriangleMesh read_ply(const std::filesystem::path& path);

}  // namespace marco::files
