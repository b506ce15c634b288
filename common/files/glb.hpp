#pragma once

#include <filesystem>

#include "common/textured_mesh.hpp"

namespace marco::files {

/// Binary glTF 2.0, one mesh: positions, normals and colours where there are any. glTF's y is up:
/// the one node turns our z there.
/// @throws std::runtime_error naming the path when it cannot be written.
void write_glb(const std::filesystem::path& path, const TriangleMesh& mesh);

/// The same with a picture, PNG or JPEG by its first bytes.
/// @throws std::invalid_argument unless there is one uv a vertex and the picture is one of these.
void write_glb(const std::filesystem::path& path, const TexturedMesh& textured);

/// What write_glb wrote, in its own frame (z up); of other programs' files, those of one mesh with
/// the same kinds of numbers.
/// @throws std::invalid_argument naming the path and what is wrong with it.
TexturedMesh read_glb(const std::filesystem::path& path);

}  // namespace marco::files
