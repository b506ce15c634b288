#include "mapping3d/surface/beam_noise.hpp"

#include <algorithm>
#include <cmath>

namespace marco::mapping3d {
namespace {

// A third of the windows lies below the noise that is fitted: the others have edges in them.
constexpr double kQuantile = 1.0 / 3.0;
// At a steeper slant most windows cross an edge: sin^2 of 75 deg.
constexpr double kMaxSlant = 0.933;
constexpr double kMinResidual2 = 1e-20;
// Of a scene's windows: neighbours overlap.
constexpr int kEvery = 3;

}  // namespace

double BeamNoise::in(const WindowPlane& plane) const {
  return std::sqrt(range_m * range_m * plane.by_range +
                   direction_rad * direction_rad * plane.by_direction);
}

double BeamNoise::at_range_m(double at_m, double tangent2) const {
  return std::sqrt(range_m * range_m +
                   at_m * at_m * direction_rad * direction_rad * std::max(0.0, tangent2));
}

void BeamNoiseLearner::add(const ScenePoints& scene) {
  const SceneWindows windows(scene);
  for (int row = kEvery / 2; row < windows.rows(); row += kEvery) {
    for (int column = kEvery / 2; column < windows.columns(); column += kEvery) {
      if (!(windows.range_m(windows.at(row, column)) > 0.0)) continue;
      const WindowPlane plane =
          windows.fit(row, column, windows.reach(row, column, SceneWindows::kLargest));
      if (!std::isfinite(plane.residual)) continue;
      if (plane.by_direction > kMaxSlant * plane.m.squaredNorm()) continue;
      windows_.push_back({std::max(kMinResidual2, plane.residual * plane.residual), plane.by_range,
                          plane.by_direction});
    }
  }
}

double BeamNoiseLearner::loss(const BeamNoise& noise) const {
  const double range2 = noise.range_m * noise.range_m;
  const double direction2 = noise.direction_rad * noise.direction_rad;
  const std::size_t every = 1 + windows_.size() / 20000;
  double sum = 0.0;
  for (std::size_t i = 0; i < windows_.size(); i += every) {
    const Window& window = windows_[i];
    const double over =
        std::log(window.residual2 / (range2 * window.by_range + direction2 * window.by_direction));
    sum += std::max(kQuantile * over, (kQuantile - 1.0) * over);
  }
  return sum;
}

BeamNoise BeamNoiseLearner::noise(double min_range_m, double max_range_m) const {
  if (windows_.empty()) return {max_range_m, 0.0};
  BeamNoise best{std::sqrt(min_range_m * max_range_m), 1e-3};
  double least = loss(best);
  const auto try_one = [&](const BeamNoise& other) {
    const double own = loss(other);
    if (own < least) {
      least = own;
      best = other;
    }
  };
  for (double factor = 2.0; factor > 1.02; factor = std::sqrt(factor)) {
    for (double before = 1e300; least < before;) {
      before = least;
      const BeamNoise from = best;
      for (const double by : {1.0 / factor, factor}) {
        try_one({std::clamp(from.range_m * by, min_range_m, max_range_m), best.direction_rad});
        try_one({best.range_m, from.direction_rad * by});
      }
    }
  }
  return best;
}

}  // namespace marco::mapping3d
