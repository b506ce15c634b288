#include "mapping3d/surface/scene_smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mapping3d/surface/scene_windows.hpp"

namespace marco::mapping3d {
namespace {

// More scenes of the same laser tell nothing new about its noise.
constexpr std::size_t kNoiseScenes = 64;

class Smoother {
 public:
  Smoother(const ScenePoints& scene, const BeamNoise& noise, const SmoothingOptions& options)
      : scene_(scene), noise_(noise), options_(options), windows_(scene) {
    validate(options, "scene_smoothing");
  }

  SmoothScene run() {
    result_.rows = scene_.rows;
    result_.columns = scene_.columns;
    result_.noise = noise_;
    result_.origins_m = scene_.origins_m;
    result_.points_m = scene_.points_m;
    const std::size_t count = scene_.points_m.size();
    result_.normals.resize(count, Eigen::Vector3f::Zero());
    result_.sigmas_m.resize(count, 0.0F);
    result_.kinds.resize(count, SmoothScene::Kind::none);
    for (int row = 0; row < windows_.rows(); ++row) {
      for (int column = 0; column < windows_.columns(); ++column) place_beam(row, column);
    }
    return std::move(result_);
  }

 private:
  void place_beam(int row, int column) {
    const std::size_t index = windows_.at(row, column);
    if (windows_.range_m(index) <= 0.0) return;
    const Eigen::Vector3d origin = scene_.origins_m[static_cast<std::size_t>(row)].cast<double>();
    const Eigen::Vector3d beam = scene_.points_m[index].cast<double>() - origin;
    for (int half = SceneWindows::kLargest; half >= 1; --half) {
      if (move_to_plane(row, column, half)) return;
    }
    result_.kinds[index] = SmoothScene::Kind::loose;
    result_.normals[index] = (-beam.normalized()).cast<float>();
    result_.sigmas_m[index] = static_cast<float>(noise_.range_m);
  }

  // Of windows that still contain the beam, and share its middle third with it.
  static int shift(int steps, int half) {
    return half == 1 ? steps : std::max(1, (steps * (half - 1) + half / 2) / half);
  }

  bool move_to_plane(int row, int column, int half) {
    const std::size_t index = windows_.at(row, column);
    const double r = windows_.range_m(index);
    const Eigen::Vector3d q = (scene_.points_m[index].cast<double>() - windows_.centre_m()) / r;
    const WindowReach reach = windows_.reach(row, column, half);
    const int down = shift(reach.rows, half), aside = shift(reach.columns, half);
    WindowPlane best;
    double best_score = std::numeric_limits<double>::infinity();
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int y = row + dy * down, x = column + dx * aside;
        if (y < 0 || x < 0 || y >= windows_.rows() || x >= windows_.columns()) continue;
        const WindowPlane plane = windows_.fit(y, x, reach);
        if (!(plane.residual < options_.plane_residual * noise_.in(plane))) continue;
        const double slope = plane.m.dot(q);
        if (!(slope > 0.0)) continue;
        const double tangent2 = plane.m.squaredNorm() / (slope * slope) - 1.0;
        const double own_m = options_.own_residual * noise_.at_range_m(r, tangent2);
        if (std::abs(slope - 1.0 / r) * r * r > own_m) continue;
        // The fit must be better by as much as an off-centre window costs in variance.
        const double score = plane.residual * (1.0 + 0.15 * (dx * dx + dy * dy));
        if (score >= best_score) continue;
        best_score = score;
        best = plane;
      }
    }
    return best_score < std::numeric_limits<double>::infinity() && settle(row, index, best, q);
  }

  bool settle(int row, std::size_t index, const WindowPlane& plane, const Eigen::Vector3d& q) {
    const Eigen::Vector3d origin = scene_.origins_m[static_cast<std::size_t>(row)].cast<double>();
    const Eigen::Vector3d beam = scene_.points_m[index].cast<double>() - origin;
    const double range_m = beam.norm();
    const double slope = plane.m.dot(beam) / range_m;
    if (!(slope > 0.0)) return false;
    const double cosine = slope / plane.m.norm();
    const double sigma_m = noise_.at_range_m(range_m, 1.0 / (cosine * cosine) - 1.0);
    const double moved_m = (1.0 - plane.m.dot(origin - windows_.centre_m())) / slope;
    if (std::abs(moved_m - range_m) > 2.0 * options_.own_residual * sigma_m) return false;
    result_.points_m[index] = (origin + beam * (moved_m / range_m)).cast<float>();
    result_.normals[index] = (-plane.m.normalized()).cast<float>();
    const double leverage = q.dot(plane.covariance * q);
    result_.sigmas_m[index] = static_cast<float>(sigma_m * cosine * std::sqrt(leverage));
    result_.kinds[index] = SmoothScene::Kind::plane;
    return true;
  }

  const ScenePoints& scene_;
  BeamNoise noise_;
  SmoothingOptions options_;
  SceneWindows windows_;
  SmoothScene result_;
};

}  // namespace

BeamNoise learn_noise(const PlacedScenes& scenes, const SmoothingOptions& options) {
  BeamNoiseLearner learner;
  const std::size_t every = 1 + scenes.count / kNoiseScenes;
  for (std::size_t i = 0; i < scenes.count; i += every) learner.add(scenes.at(i));
  return learner.noise(options.min_sigma_m, options.max_sigma_m);
}

SmoothScene smooth(const ScenePoints& scene,
                   const BeamNoise& noise,
                   const SmoothingOptions& options) {
  return Smoother(scene, noise, options).run();
}

}  // namespace marco::mapping3d
