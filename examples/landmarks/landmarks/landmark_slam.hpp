#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <vector>

#include "common/trajectory.hpp"
#include "landmarks/landmark_slam_options.hpp"
#include "landmarks/noise_learner.hpp"
#include "landmarks/point_filter.hpp"
#include "landmarks/provisional_landmarks.hpp"
#include "landmarks/sighting_association.hpp"
#include "landmarks/sighting_correlation.hpp"
#include "landmarks/visibility.hpp"
#include "landmarks/wheel_integral.hpp"

namespace marco::slam {

/// A landmark of the map.
struct MapLandmark {
  int64_t id = 0;
  Eigen::Vector2d in_world_m;
  Eigen::Matrix2d covariance;
  double diameter_m = 0.0;  ///< mean of its sightings; 0 = not measured
  int64_t times_seen = 0;
  double existence = 0.0;  ///< probability
};

/// What one scan of sightings changed.
struct LandmarkUpdate {
  int paired = 0, unclear = 0, added = 0, joined = 0, removed = 0;
};

/// SLAM with point landmarks (posts, trees, corners) that are not told apart. Causal: an estimate
/// rests on what came before it. Steps of one scan: move, associate, correct, confirm new ones,
/// join doubled ones, judge by what should have been seen, learn the noise.
/// The first half minute or so is gone through twice: the map's place and turn hang on it, and the
/// noise is known only at its end. Landmarks then get new ids.
/// World frame: the robot's place at its first sample. Not thread-safe.
class LandmarkSlam {
 public:
  /// @throws std::invalid_argument naming an option outside its limits.
  explicit LandmarkSlam(const LandmarkSlamOptions& options);

  /// @returns false where the sample is not usable
  bool process(const WheelVelocity& sample);
  /// @param scan  not older than the last one, nor than the last wheel velocity
  LandmarkUpdate process(const SightingScan& scan);

  /// By all that was processed.
  Pose2 world_from_robot() const;
  /// Of (x, y, theta), world frame, after the last scan.
  Eigen::Matrix3d robot_covariance() const { return filter_.robot_covariance(); }
  /// Landmarks that probably exist. @param least_existence  probability
  std::vector<MapLandmark> landmarks(double least_existence = 0.9) const;
  const SightingNoise& noise() const { return learner_.noise(); }
  /// See SightingCorrelation.
  double noise_factor() const { return correlation_.noise_factor(); }
  const PointFilter& filter() const { return filter_; }

 private:
  struct Record {
    int64_t id = 0;
    double evidence = 0.0;  ///< log odds that it exists
    int64_t times_seen = 0;
    double diameter_sum_m = 0.0;
    int64_t diameters = 0;
    std::set<int64_t> seen_beside;  ///< ids of landmarks near it that one scan saw as well

    void count(const Sighting& sighting);
  };
  /// What there was to go through again, until then.
  struct Beginning {
    std::vector<WheelVelocity> wheels;
    std::vector<SightingScan> scans;
  };
  LandmarkUpdate take(const SightingScan& scan);
  void begin_again();
  void add(const Sighting& sighting);
  void correct(const std::vector<SightingOf>& seen);
  /// Of sightings that repeat each other's errors, as if they did not.
  SightingNoise independent_noise() const;
  void forget(int index);
  void note_neighbours(const std::vector<SightingOf>& seen);
  int join_doubled(const std::vector<SightingOf>& seen);
  bool are_one(int a, int b) const;
  int judge(const std::vector<SightingMatch>& matches, double moved_m);

  LandmarkSlamOptions options_;
  std::optional<Beginning> beginning_;
  WheelIntegral wheels_;
  PointFilter filter_;
  NoiseLearner learner_;
  SightingCorrelation correlation_;
  Visibility visibility_;
  ProvisionalLandmarks provisional_;
  std::vector<Record> records_;  ///< by the filter's index
  int64_t next_id_ = 1;
  int64_t scan_ = 0;
};

}  // namespace marco::slam
