#pragma once

#include <filesystem>

#include "common/triangle_mesh.hpp"

namespace marco::files {

/// Wavefront OBJ as text: metres, z up, to a tenth of a millimetre; normals and colours (after the
/// position, 0..1) where the mesh has them.
/// @throws std::runtime_error naming the path when it cannot be written.
void write_obj(const std::filesystem::path& path, const TriangleMesh& mesh);

/// Positions, normals, colours after the position, and faces; of a face with more than three
/// corners the fan about its first one. Materials, groups, texture coordinates, lines and curves
/// are ignored. A vertex that faces use with several normals gets their mean direction.
/// Normals, and colours, are read only where all faces' vertices have them.
/// @throws std::invalid_argument naming file and line, and what is wrong there.
TriangleMesh read_obj(const std::filesystem::path& path);

}  // namespace marco::files
