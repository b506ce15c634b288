#pragma once

#include <vector>

#include "common/triangle_mesh.hpp"
#include "mapping3d/surface/scene_smoothing.hpp"
#include "mapping3d/surface/surface_model.hpp"

namespace marco::mapping3d {

/// Adds to a fused mesh what its voxels cannot hold: things smaller than a few voxels, and far ones
/// that a few beams hit. They come as facets between those beams, in pieces of common returns. A
/// piece lies farther than two voxels from the mesh and is no mixed range: most of its returns do
/// not lie between the ranges of its neighbours on both sides. Where an earlier scene has a piece
/// that faces the same way, a later one adds nothing. A piece that as many scenes looked through as
/// saw it was of something that moved, and is left out.
/// @param placed, smoothed  the same scenes; each is asked for once
void add_small_pieces(const PlacedScenes& placed,
                      const SmoothScenes& smoothed,
                      const SurfaceOptions& options,
                      TriangleMesh& mesh);

}  // namespace marco::mapping3d
