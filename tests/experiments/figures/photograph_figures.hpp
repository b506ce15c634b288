#pragma once

#include <filesystem>
#include <vector>

#include "common/pose3.hpp"
#include "common/triangle_mesh.hpp"
#include "tests/experiments/figures/thesis_figures.hpp"

namespace marco {

/// A picture of the recording, of a camera without distortion whose axis meets its middle.
struct PosedPhotograph {
  std::filesystem::path file;
  Pose3 world_from_camera;  ///< z ahead, y down
  double focal_px = 0.0;
};

/// Thesis B's figures 5.12 and 5.18, the real scenes: of each stop, up to two, the photograph that
/// shows what its first full sweep saw, beside the model from the same place.
/// @param model  world frame. @returns nothing where there are no photographs or no model.
std::vector<Figure> draw_photograph_figures(
    const std::filesystem::path& folder,
    const std::vector<PosedPhotograph>& photographs,
    const std::vector<std::vector<mapping3d::ScenePoints>>& stops,
    const TriangleMesh& model);

}  // namespace marco
