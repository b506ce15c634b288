#pragma once

#include <filesystem>

#include "common/triangle_mesh.hpp"

namespace marco::files {

/// Wavefront OBJ as text: metres, z up, to a tenth of a millimetre; normals and colours (after the
/// position, 0..1) where the mesh has them.
/// @throws std::runtime_error naming the path when it cannot be written.
void write_obj(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace marco::files
