#include "mapping3d/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "common/linear_algebra.hpp"

namespace marco::mapping3d {
namespace {

constexpr int kParameters = 8;
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Information = Eigen::Matrix<double, kParameters, kParameters>;
// The first are lengths [m], then come angles [rad] and a time [s].
constexpr Eigen::Index kLengths = 4, kAngles = 3, kLate = 7;
constexpr std::size_t kMinPairs = 60;  // some equations for each parameter
// Of the correction as a whole: the 0.999 quantile of chi2 of as many degrees of freedom.
constexpr double kSureChi2 = 26.1;

PanTiltCorrection to_correction(const Parameters& p) {
  return {p[0], p[1], p[2], p[3], rad_to_deg(p[4]), rad_to_deg(p[5]), rad_to_deg(p[6]), p[kLate]};
}

/// Where a patch's centre goes when a parameter grows.
using Derivatives = Eigen::Matrix<double, 3, kParameters>;

struct Sweep {
  std::unique_ptr<SurfelIndex> index;
  std::vector<Derivatives> derivatives;
};

using System = NormalEquations<kParameters>;

class Calibrator {
 public:
  Calibrator(const std::vector<Scene>& scenes,
             const PanTiltGeometry& geometry,
             const CalibrationOptions& options)
      : scenes_(scenes), geometry_(geometry), options_(options), association_(options.matching) {
    validate(options, "calibration");
    find_pairs();
  }

  CalibrationResult run() {
    CalibrationResult result;
    Parameters parameters = Parameters::Zero();
    MatchingScales scales = MatchingScales::first(options_.matching);
    result.before_m = median_residual(parameters);
    System system;
    for (int i = 0; i < options_.max_iterations; ++i) {
      const bool narrowest = scales.narrowest(options_.matching);
      system = compare(parameters, scales);
      result.pairs = residuals_m_.size();
      if (result.pairs < kMinPairs) return result;
      const Parameters step = solve(system, parameters);
      parameters += step;
      if (narrowest && step.cwiseAbs().maxCoeff() < 1e-5) {
        result.status = CalibrationResult::Status::converged;
        break;
      }
      result.status = CalibrationResult::Status::not_converged;
      scales.shrink(options_.matching);
    }
    result.after_m = median_residual(parameters);
    result.found = to_correction(parameters);
    const double variance = std::pow(std::max(1e-5, 1.5 * result.after_m), 2);
    const Information information = system.information / variance + prior();
    result.sigma = to_correction(inverse_of(information).diagonal().cwiseSqrt());
    if (parameters.dot(information * parameters) > kSureChi2) result.correction = result.found;
    return result;
  }

 private:
  void find_pairs() {
    for (std::size_t a = 0; a < scenes_.size(); ++a) {
      for (std::size_t b = a + 1; b < scenes_.size(); ++b) {
        if (scenes_[a].rows.empty() || scenes_[b].rows.empty()) continue;
        const Pose2 apart = between(scenes_[a].rows.front().world_from_robot,
                                    scenes_[b].rows.front().world_from_robot);
        if (apart.translation_m().norm() <= options_.same_stop_m) pairs_.emplace_back(a, b);
      }
    }
  }

  Information prior() const {
    Parameters information;
    information.head<kLengths>().setConstant(1.0 / (options_.prior_m * options_.prior_m));
    const double prior_rad = deg_to_rad(options_.prior_deg);
    information.segment<kAngles>(kLengths).setConstant(1.0 / (prior_rad * prior_rad));
    information[kLate] = 1.0 / (options_.prior_s * options_.prior_s);
    return information.asDiagonal();
  }

  /// A residual counts as some millimetres wrong in addition to the prior.
  Parameters solve(const System& system, const Parameters& parameters) const {
    constexpr double kResidualVarianceM2 =
        0.005 * 0.005;  // of points to their surfaces: noise of the ranges, less by averaging
    const Information by_prior = kResidualVarianceM2 * prior();
    return inverse_of(system.information + by_prior) * (-system.gradient - by_prior * parameters);
  }

  ScenePoints place_with(const Scene& scene, const Parameters& parameters) const {
    const PanTiltCorrection correction = to_correction(parameters);
    const SensorInfo base = correction.base(geometry_.base);
    const SensorInfo sensor = correction.sensor(geometry_.sensor);
    Scene corrected = scene;
    for (SceneRow& row : corrected.rows) {
      // By the rate within the row: between rows a pan-tilt may have stopped.
      const double rows_late = row.duration_s > 0.0 ? correction.late_s / row.duration_s : 0.0;
      const double pan_rad = rows_late * normalize_angle(row.pan_last_rad - row.pan_first_rad);
      const double tilt_rad = rows_late * (row.tilt_last_rad - row.tilt_first_rad);
      row.robot_from_sensor_first = robot_from_pantilt_sensor(
          base, sensor, row.pan_first_rad + pan_rad, row.tilt_first_rad + tilt_rad);
      row.robot_from_sensor_last = robot_from_pantilt_sensor(
          base, sensor, row.pan_last_rad + pan_rad, row.tilt_last_rad + tilt_rad);
    }
    return place(corrected);
  }

  Eigen::Vector3d center(const ScenePoints& scene, const Surfel& surfel) const {
    const auto block = static_cast<std::size_t>(options_.matching.surfels.block_cells);
    return *block_mean(scene, {surfel.row, surfel.column, block, block});
  }

  Sweep sweep(const Scene& scene, const Parameters& parameters) const {
    constexpr double kStep = 0.005;  // of metres and radians; floats are good to a micrometre
    Sweep result;
    result.index = std::make_unique<SurfelIndex>(
        find_surfels(place_with(scene, parameters), options_.matching.surfels));
    const std::vector<Surfel>& surfels = result.index->surfels;
    result.derivatives.resize(surfels.size());
    for (Eigen::Index k = 0; k < kParameters; ++k) {
      const Parameters change = kStep * Parameters::Unit(k);
      const ScenePoints more = place_with(scene, parameters + change);
      const ScenePoints less = place_with(scene, parameters - change);
      for (std::size_t i = 0; i < surfels.size(); ++i) {
        result.derivatives[i].col(k) =
            (center(more, surfels[i]) - center(less, surfels[i])) / (2.0 * kStep);
      }
    }
    return result;
  }

  System compare(const Parameters& parameters, const MatchingScales& scales) {
    std::vector<Sweep> sweeps;
    for (const Scene& scene : scenes_) sweeps.push_back(sweep(scene, parameters));
    residuals_m_.clear();
    System system;
    for (const auto& [a, b] : pairs_) add_pair(sweeps[a], sweeps[b], scales, system);
    return system;
  }

  void add_pair(const Sweep& a, const Sweep& b, const MatchingScales& scales, System& system) {
    for (std::size_t i = 0; i < b.index->surfels.size(); ++i) {
      const Surfel& moved = b.index->surfels[i];
      const auto found = association_.find(*a.index, moved.center_m, moved.normal, scales.search_m);
      if (!found) continue;
      residuals_m_.push_back(std::abs(found->residual_m));
      if (a.derivatives.empty()) continue;
      const Parameters jacobian =
          (b.derivatives[i] - a.derivatives[found->partner]).transpose() * found->normal;
      const double thickness2_m2 =
          moved.thickness2_m2() + a.index->surfels[found->partner].thickness2_m2();
      system.add(jacobian, found->residual_m,
                 association_.weight(found->residual_m, scales.lorentz_m, thickness2_m2));
    }
  }

  double median_residual(const Parameters& parameters) {
    std::vector<Sweep> sweeps(scenes_.size());
    for (std::size_t i = 0; i < scenes_.size(); ++i) {
      sweeps[i].index = std::make_unique<SurfelIndex>(
          find_surfels(place_with(scenes_[i], parameters), options_.matching.surfels));
    }
    residuals_m_.clear();
    System unused;
    for (const auto& [a, b] : pairs_) {
      add_pair(sweeps[a], sweeps[b], MatchingScales::last(options_.matching), unused);
    }
    return quantile(residuals_m_, 0.5);
  }

  const std::vector<Scene>& scenes_;
  PanTiltGeometry geometry_;
  CalibrationOptions options_;
  SurfelAssociation association_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  std::vector<double> residuals_m_;
};

}  // namespace

std::string to_string(CalibrationResult::Status status) {
  switch (status) {
    case CalibrationResult::Status::converged:
      return "converged";
    case CalibrationResult::Status::not_converged:
      return "not converged";
    case CalibrationResult::Status::nothing_seen_twice:
      return "no surface seen twice";
  }
  return "unknown";
}

CalibrationResult calibrate(const std::vector<Scene>& scenes,
                            const PanTiltGeometry& geometry,
                            const CalibrationOptions& options) {
  return Calibrator(scenes, geometry, options).run();
}

}  // namespace marco::mapping3d
