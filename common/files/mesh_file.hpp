#pragma once

#include <filesystem>

#include "common/triangle_mesh.hpp"

namespace marco::files {

/// A mesh without a picture: read_obj() where the name ends in .obj, else read_ply().
/// @throws std::invalid_argument as they do.
TriangleMesh read_mesh(const std::filesystem::path& path);

}  // namespace marco::files
