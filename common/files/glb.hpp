#pragma once

#include <filesystem>

#include "common/textured_mesh.hpp"

namespace marco::files {

/// What a GLB's numbers take: 4 bytes each, or a fourth or less of that in all.
enum class GlbNumbers {
  plain,
  /// EXT_meshopt_compression and KHR_mesh_quantization, which readers must know: positions to half
  /// a millimetre, normals to two degrees, uvs to 1/65535, colours as they are. Triangles and
  /// vertices come in another order, and vertices of no triangle are left out.
  compressed
};

/// Binary glTF 2.0, one mesh: positions, normals and colours where there are any. glTF's y is up:
/// the one node turns our z there.
/// @throws std::runtime_error naming the path when it cannot be written; std::invalid_argument when
/// a position to be compressed is not within 8 km.
void write_glb(const std::filesystem::path& path,
               const TriangleMesh& mesh,
               GlbNumbers numbers = GlbNumbers::plain);

/// The same with a picture, PNG or JPEG by its first bytes.
/// @throws std::invalid_argument unless there is one uv a vertex and the picture is one of these;
/// of uvs to be compressed, also unless they are in 0..1.
void write_glb(const std::filesystem::path& path,
               const TexturedMesh& textured,
               GlbNumbers numbers = GlbNumbers::plain);

/// What write_glb wrote, compressed or not, in its own frame (z up); of other programs' files,
/// those of one mesh with the same kinds of numbers.
/// @throws std::invalid_argument naming the path and what is wrong with it.
TexturedMesh read_glb(const std::filesystem::path& path);

}  // namespace marco::files
