#pragma once

#include <vector>

#include "mapping3d/surface/scene_windows.hpp"

namespace marco::mapping3d {

/// A laser's noise, as its own sweeps show it: standard deviations.
struct BeamNoise {
  double range_m = 0.0;
  /// Of a beam's direction: of the pan-tilt's angles, of the motion, and of the beam's width, which
  /// smears the range where a surface lies at a slant. Near 0 in a simulation.
  double direction_rad = 0.0;

  /// Of one inverse range in a window, rms [1/m].
  double in(const WindowPlane& plane) const;
  /// Of one range, to a plane that its beam meets at an angle of this squared tangent.
  double at_range_m(double range_m, double tangent2) const;
};

/// Learns the noise from windows of all sweeps. Most windows lie within one surface, so the lower
/// third of their residuals is noise: a quantile regression (Koenker and Bassett 1978) of the
/// residuals' logarithms on both parts, which windows at different ranges and slants tell apart.
class BeamNoiseLearner {
 public:
  /// A sample of the scene's windows.
  void add(const ScenePoints& scene);

  /// @param min_range_m, max_range_m  limits of the noise of the range; the upper one is returned
  /// where there is no window
  BeamNoise noise(double min_range_m, double max_range_m) const;

 private:
  struct Window {
    double residual2, by_range, by_direction;
  };
  double loss(const BeamNoise& noise) const;

  std::vector<Window> windows_;
};

}  // namespace marco::mapping3d
