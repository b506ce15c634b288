#pragma once

#include <functional>
#include <random>
#include <vector>

#include "common/pose3.hpp"
#include "simulator/ray_caster.hpp"
#include "simulator/simulation_options.hpp"

namespace marco::sim {

/// The ranges that a time-of-flight laser measures, with its faults (thesis B ch. 3.2.1): an edge
/// mixes two ranges, black returns nothing at a slant, and glass is opaque, transparent or a mirror
/// depending on the angle.
class LaserModel {
 public:
  /// @param rays outlives the model.
  LaserModel(const RayCaster& rays, const LaserOptions& options);

  /// @param world_from_sensor  at a time in seconds after the first beam. Asked in the order of the
  /// beams, each at its own time (LaserOptions::time_of_beam_s).
  /// @returns the ranges as a device would send them; options.no_return_m where nothing came back.
  std::vector<float> scan(const std::function<Pose3(double)>& world_from_sensor,
                          std::mt19937_64& random) const;

 private:
  std::optional<float> first_return(Eigen::Vector3f origin_m, Eigen::Vector3f direction) const;
  std::optional<double> beam(const Pose3& world_from_sensor,
                             double bearing_rad,
                             std::mt19937_64& random) const;

  const RayCaster& rays_;
  LaserOptions options_;
};

}  // namespace marco::sim
