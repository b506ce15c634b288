#pragma once

#include <string>
#include <string_view>

#include "common/files/glb_builder.hpp"
#include "common/triangle_mesh.hpp"

namespace marco::files {

/// Adds a mesh by EXT_meshopt_compression and KHR_mesh_quantization, see GlbNumbers::compressed.
/// @param uvs  empty or one a vertex. @returns a primitive's attributes and indices.
/// @throws std::invalid_argument when a number is too large for its form.
nlohmann::json compressed_numbers(GlbBuilder& builder,
                                  const TriangleMesh& mesh,
                                  const std::vector<Eigen::Vector2f>& uvs);

/// The bytes of a bufferView whose extension says `how` they are `packed`.
/// @throws std::invalid_argument saying what is wrong with them, nlohmann::json::exception where
/// `how` lacks a word. Never allocates more than 64 times as much as it got.
std::string unpacked(std::string_view packed, const nlohmann::json& how);

}  // namespace marco::files
