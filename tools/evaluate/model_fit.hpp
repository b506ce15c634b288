#pragma once

#include <cstddef>

#include "common/pose3.hpp"
#include "common/triangle_mesh.hpp"
#include "simulator/ray_caster.hpp"

namespace marco {

struct ModelFit {
  Pose3 world_from_model = Pose3::Identity();
  std::size_t samples = 0;  ///< with a surface within 0.3 m
  double rms_m = 0.0;       ///< of those
};

/// Aligns a model with a world, starting from a guess: point to plane, with a Lorentzian kernel.
ModelFit fit_model(const TriangleMesh& model, const sim::RayCaster& world, const Pose3& guess);

/// The same without a guess, for a model whose z is up: tries headings and positions on a coarse
/// distance field, then refines the best few. A symmetric world can mislead it.
ModelFit find_model(const TriangleMesh& model, const sim::RayCaster& world);

}  // namespace marco
