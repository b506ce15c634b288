#pragma once

#include <functional>
#include <random>
#include <vector>

#include "common/pose3.hpp"
#include "simulator/ray_caster.hpp"
#include "simulator/simulation_options.hpp"

namespace marco::sim {

/// A laser at a moment.
struct LaserMoment {
  Pose3 world_from_sensor = Pose3::Identity();
  /// Of the world's clock, by which people walk: since the tour began, or, live, since 1970.
  double seconds = 0.0;
};

/// The ranges that a time-of-flight laser measures, with its faults (thesis B ch. 3.2.1): an edge
/// mixes two ranges, black returns nothing at a slant, and glass is opaque, transparent or a mirror
/// depending on the angle. People are seen where they are at the time of each beam.
class LaserModel {
 public:
  /// @param rays outlives the model.
  LaserModel(const RayCaster& rays, const LaserOptions& options);

  /// @param moment  at a time in seconds after the first beam. Asked in the order of the beams,
  /// each at its own time (LaserOptions::time_of_beam_s).
  /// @returns the ranges as a device would send them; options.no_return_m where nothing came back.
  std::vector<float> scan(const std::function<LaserMoment(double)>& moment,
                          std::mt19937_64& random) const;

 private:
  using Legs = std::vector<Leg>;

  Legs legs_at(double seconds) const;
  std::optional<RayHit> cast(const Legs& legs,
                             const Eigen::Vector3f& origin_m,
                             const Eigen::Vector3f& direction,
                             float max_range_m) const;
  std::optional<float> first_return(const Legs& legs,
                                    Eigen::Vector3f origin_m,
                                    Eigen::Vector3f direction) const;
  std::optional<double> beam(const LaserMoment& moment,
                             double bearing_rad,
                             std::mt19937_64& random) const;

  const RayCaster& rays_;
  LaserOptions options_;
};

}  // namespace marco::sim
