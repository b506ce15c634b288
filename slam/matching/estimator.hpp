#pragma once

#include <cmath>
#include <string>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {

/// Robust kernels. The thesis (Cortes, 2007, ch. 3.4, fig. 3.5) compares the Lorentzian with least
/// squares; Geman-McClure, which downweights outliers even more, is ours.
enum class EstimatorKind { least_squares, lorentzian, geman_mcclure };

/// @param name `least_squares`, `lorentzian` or `geman_mcclure`. @throws std::invalid_argument.
inline EstimatorKind estimator_kind(const std::string& name) {
  if (name == "least_squares") return EstimatorKind::least_squares;
  if (name == "lorentzian") return EstimatorKind::lorentzian;
  require(name == "geman_mcclure", "estimator '" + name +
                                       "' is unknown; use least_squares, lorentzian or "
                                       "geman_mcclure");
  return EstimatorKind::geman_mcclure;
}

/// A robust kernel (M-estimator) of residuals e [m]:
///   least squares    ρ = e²                            (σ is not used)
///   Lorentzian       ρ = log(1 + (e/σ)²/2)             (ch. 3.4)
///   Geman-McClure    ρ = e² / (σ² + e²)
struct Estimator {
  EstimatorKind kind = EstimatorKind::lorentzian;
  double sigma_m = 0.05;  ///< > 0: residuals well beyond it lose their influence

  double rho(double e) const {
    const double s2 = sigma_m * sigma_m, e2 = e * e;
    switch (kind) {
      case EstimatorKind::least_squares:
        return e2;
      case EstimatorKind::lorentzian:
        return std::log1p(0.5 * e2 / s2);
      case EstimatorKind::geman_mcclure:
        return e2 / (s2 + e2);
    }
    return 0.0;
  }
  /// dρ/de; of the Lorentzian 2e / (2σ² + e²).
  double influence(double e) const { return e * weight(e); }
  /// influence / e, finite at e = 0: the weight of iteratively reweighted least squares.
  double weight(double e) const {
    const double s2 = sigma_m * sigma_m, e2 = e * e;
    switch (kind) {
      case EstimatorKind::least_squares:
        return 2.0;
      case EstimatorKind::lorentzian:
        return 2.0 / (2.0 * s2 + e2);
      case EstimatorKind::geman_mcclure:
        return 2.0 * s2 / ((s2 + e2) * (s2 + e2));
    }
    return 0.0;
  }
  /// d²ρ/de²; of the Lorentzian 2 (D - 2e²) / D² with D = 2σ² + e². Negative for outliers.
  double curvature(double e) const {
    const double s2 = sigma_m * sigma_m, e2 = e * e;
    switch (kind) {
      case EstimatorKind::least_squares:
        return 2.0;
      case EstimatorKind::lorentzian: {
        const double d = 2.0 * s2 + e2;
        return 2.0 * (d - 2.0 * e2) / (d * d);
      }
      case EstimatorKind::geman_mcclure: {
        const double d = s2 + e2;
        return 2.0 * s2 * (s2 - 3.0 * e2) / (d * d * d);
      }
    }
    return 0.0;
  }
};

}  // namespace marco::slam
