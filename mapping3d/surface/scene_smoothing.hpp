#pragma once

#include <functional>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/surface/beam_noise.hpp"

namespace marco::mapping3d {

struct SmoothingOptions {
  double min_sigma_m = 0.003;  ///< bounds of the estimated range noise
  double max_sigma_m = 0.03;
  double plane_residual = 1.4;  ///< largest rms residual of a planar window, in sigmas
  double own_residual = 3.5;    ///< largest residual of a beam on it, in sigmas

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_sigma_m", min_sigma_m, kPositive);
    v("max_sigma_m", max_sigma_m, kPositive);
    v("plane_residual", plane_residual, kPositive);
    v("own_residual", own_residual, kPositive);
  }
};

/// A scene with the laser's noise averaged out within surfaces.
struct SmoothScene {
  enum class Kind : uint8_t { none, loose, plane };

  std::size_t rows = 0;
  std::size_t columns = 0;
  BeamNoise noise;                         ///< that its beams were taken to have
  std::vector<Eigen::Vector3f> points_m;   ///< on its own beam; loose ones as they were measured
  std::vector<Eigen::Vector3f> normals;    ///< towards the sensor; of loose ones against the beam
  std::vector<float> sigmas_m;             ///< of a point, along its normal
  std::vector<Kind> kinds;                 ///< none = no return
  std::vector<Eigen::Vector3f> origins_m;  ///< one a row
};

/// Scenes that are smoothed when they are asked for; see PlacedScenes.
struct SmoothScenes {
  std::size_t count = 0;
  std::function<SmoothScene(std::size_t)> at;
};

/// The noise of the laser that took these scenes, from a sample of them.
BeamNoise learn_noise(const PlacedScenes& scenes, const SmoothingOptions& options = {});
inline BeamNoise learn_noise(const std::vector<ScenePoints>& scenes,
                             const SmoothingOptions& options = {}) {
  return learn_noise(PlacedScenes::of(scenes), options);
}

/// Edge-preserving smoothing with normals: fits planes to windows of about 7 x 7, 5 x 5 and 3 x 3
/// beams, linear in the inverse range (m q = 1/r for unit directions q and the plane m x = 1 about
/// the mean sensor), and moves each beam's end along the beam to the plane of the largest window
/// that contains it and fits within the noise. Off-centre windows let a plane reach its edge (after
/// Kuwahara 1976), so that corners stay sharp. A beam on no plane keeps its range (`loose`): thin
/// objects, mixed ranges at an edge.
SmoothScene smooth(const ScenePoints& scene,
                   const BeamNoise& noise,
                   const SmoothingOptions& options = {});

}  // namespace marco::mapping3d
