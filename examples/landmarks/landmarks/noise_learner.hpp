#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "landmarks/point_filter.hpp"

namespace marco::slam {

/// Finds the noise that makes the sightings likeliest, on the way: nine small filters follow the
/// robot against the map, one with the noise as it is taken now and two for each of its four
/// numbers, one with more and one with less of it. The logarithms of their likelihoods give slope
/// and curvature, and a Newton step every few scans follows them (maximum likelihood by central
/// differences; what a window teaches is kept as curvature, so that steps become smaller as in
/// stochastic approximation, but never below 1/kMemoryWindows). Not thread-safe.
class NoiseLearner {
 public:
  explicit NoiseLearner(const SightingNoise& start);

  const SightingNoise& noise() const { return noise_; }
  /// Steps taken so far.
  int steps() const { return steps_; }
  /// Keeps what was learned, and looks for the robot again.
  void lose_robot() { has_started_ = false; }

  /// The robot moved, and saw these landmarks, which the map knows well.
  /// @param filter  as corrected by them
  void add_scan(const WheelMotion& motion,
                const std::vector<SightingOf>& seen,
                const PointFilter& filter);

 private:
  static constexpr int kNumbers = 4;
  static constexpr int kFilters = 1 + 2 * kNumbers;

  struct Follower {
    Pose2 world_from_robot;
    Eigen::Matrix3d covariance;
    double log_likelihood = 0.0;
  };
  SightingNoise varied(int filter) const;
  void start_again(const PointFilter& filter);
  double follow(Follower& follower,
                const SightingOf& seen,
                const SightingNoise& noise,
                const PointFilter& filter) const;
  void take_step();

  SightingNoise noise_;
  std::array<Follower, kFilters> followers_;
  bool has_started_ = false;
  int scans_ = 0;
  int sightings_ = 0;
  int steps_ = 0;
  std::array<double, kNumbers> curvature_{};
};

}  // namespace marco::slam
