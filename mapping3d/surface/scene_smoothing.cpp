#include "mapping3d/surface/scene_smoothing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mapping3d/surface/scene_windows.hpp"

namespace marco::mapping3d {
namespace {

// More scenes of the same laser tell nothing new about its noise.
constexpr std::size_t kNoiseScenes = 64;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// What the beams near a window ask of it, kept: each is asked by up to nine.
struct KnownWindow {
  Eigen::Vector3f m = Eigen::Vector3f::Zero();  ///< of the plane, see WindowPlane
  float residual = 0.0F;  ///< [1/m]; infinite when it is larger than noise explains
  WindowReach reach{0, 0};

  bool is_known() const { return reach.rows > 0; }
};

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
    for (std::vector<KnownWindow>& of_size : known_) of_size.resize(count);
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

  const KnownWindow& window(int row, int column, int half) {
    KnownWindow& known = known_.at(static_cast<std::size_t>(half - 1))[windows_.at(row, column)];
    if (known.is_known()) return known;
    known.reach = windows_.reach(row, column, half);
    const WindowPlane plane = windows_.fit(row, column, known.reach);
    known.m = plane.m.cast<float>();
    const bool is_plane = plane.residual < options_.plane_residual * noise_.in(plane);
    known.residual = is_plane ? static_cast<float>(plane.residual) : kInfinity;
    return known;
  }

  bool move_to_plane(int row, int column, int half) {
    const std::size_t index = windows_.at(row, column);
    const auto r = static_cast<float>(windows_.range_m(index));
    const Eigen::Vector3f q = (scene_.points_m[index] - windows_.centre_m().cast<float>()) / r;
    const WindowReach reach = window(row, column, half).reach;
    const int down = shift(reach.rows, half), aside = shift(reach.columns, half);
    int best_row = 0, best_column = 0;
    float best_score = kInfinity;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int y = row + dy * down, x = column + dx * aside;
        if (y < 0 || x < 0 || y >= windows_.rows() || x >= windows_.columns()) continue;
        if (!(windows_.range_m(windows_.at(y, x)) > 0.0)) continue;
        const KnownWindow& at = window(y, x, half);
        // The fit must be better by as much as an off-centre window costs in variance.
        const float score = at.residual * (1.0F + 0.15F * static_cast<float>(dx * dx + dy * dy));
        if (!(score < best_score) || !contains(at, q, r)) continue;
        best_score = score;
        best_row = y;
        best_column = x;
      }
    }
    if (best_score == kInfinity) return false;
    return settle(row, index,
                  windows_.fit(best_row, best_column, window(best_row, best_column, half).reach));
  }

  /// Whether a beam of direction q and range r ends on the window's plane, within its noise.
  bool contains(const KnownWindow& at, const Eigen::Vector3f& q, float r) const {
    const float slope = at.m.dot(q);
    if (!(slope > 0.0F)) return false;
    const float tangent2 = at.m.squaredNorm() / (slope * slope) - 1.0F;
    const double own_m = options_.own_residual *
                         noise_.at_range_m(static_cast<double>(r), static_cast<double>(tangent2));
    return static_cast<double>(std::abs(slope - 1.0F / r) * r * r) <= own_m;
  }

  bool settle(int row, std::size_t index, const WindowPlane& plane) {
    const Eigen::Vector3d q =
        (scene_.points_m[index].cast<double>() - windows_.centre_m()) / windows_.range_m(index);
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
  std::array<std::vector<KnownWindow>, SceneWindows::kLargest> known_;  ///< by half-width and beam
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
