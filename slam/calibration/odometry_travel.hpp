#pragma once

#include <optional>
#include <vector>

#include "common/input/sensor_calibration.hpp"
#include "common/trajectory.hpp"

namespace marco::slam {

/// What odometry counted in all by a moment: its increments, each in the frame of its own moment,
/// summed up. Between samples the velocity is steady. Stamps that step back replace what is later,
/// as in PoseBuffer. Immutable.
class OdometryTravel {
 public:
  explicit OdometryTravel(const Trajectory& odometry);

  bool empty() const { return seconds_.size() < 2; }
  /// The median time between two samples.
  double interval_s() const;
  /// From a moment to the nearest sample, before or after.
  double to_sample_s(double moment_s) const;
  /// Whether all of [begin, end] is known: inside the samples, without a gap of more than a second
  /// or a jump to another origin. Moments in seconds.
  bool knows(double begin_s, double end_s) const;
  /// The increments between two moments, summed up; what lies outside adds nothing.
  ArcMotion between_moments(double begin_s, double end_s) const;

 private:
  ArcMotion at(double moment_s) const;

  std::vector<double> seconds_;
  std::vector<ArcMotion> sums_;
  std::vector<double> gaps_s_;  ///< where gaps begin
};

}  // namespace marco::slam
