#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "common/files/glb.hpp"
#include "mapping3d/surface_pipeline.hpp"

namespace marco {

/// Writes into `folder`: model.ply (the whole surface), model.glb and model.obj (simplified),
/// planes.json. An empty surface writes nothing.
/// @param glb_numbers  of model.glb
void write_joined_surface(const std::filesystem::path& folder,
                          const TriangleMesh& model,
                          const mapping3d::JoinedSurface& joined,
                          files::GlbNumbers glb_numbers);

/// For the report, by name with unit; none of an empty surface.
std::map<std::string, double> figures_of(const TriangleMesh& model,
                                         const mapping3d::JoinedSurface& joined,
                                         std::size_t scenes);

}  // namespace marco
