#pragma once

#include "slam/front_end/match_gates.hpp"
#include "slam/front_end/motion_model.hpp"
#include "slam/map/local_map.hpp"
#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/surfel_matcher.hpp"

namespace marco::slam {

struct ScanMatch {
  Pose2 world_from_robot;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of the scan alone, world frame
  double overlap = 0.0;                                   ///< part of the points that lie on a wall
  bool usable = false;
  double misfit_m2 = 0.0;  ///< see SurfelMatch
};

/// Whether a pose that contradicts odometry explains significantly more of a scan's points than the
/// pose that agrees with it: by kProvesLie, and by more than sampling error. Three more of 26 beams
/// are not significant.
bool proves_lie(double overlap_there, double overlap_by_odometry, double points);

/// Matches a scan against the local map: about the prediction; by an exhaustive search where that
/// fits badly; by a wider one that leaves odometry aside.
/// The rules are those of match_gates.hpp. Const: safe from several threads.
class ScanMatcher {
 public:
  ScanMatcher(const MatchGateOptions& gates,
              const SurfelMatcherOptions& fine,
              const CorrelativeMatcherOptions& coarse);

  enum class Search { prior_window, everywhere };

  /// @param keyframes  that the local map is made of
  /// @param search  prior_window: never by a search that leaves odometry aside
  /// @returns the prediction, not usable, where nothing fits.
  ScanMatch match(const OrientedPoints& points,
                  const PosePrior& prior,
                  MotionGuess::Source source,
                  const KeyframeSet& keyframes,
                  LocalMap& map,
                  Search search = Search::everywhere) const;

  /// Once more, from nearby.
  ScanMatch match_again(const OrientedPoints& points,
                        const Pose2& world_from_robot,
                        const PosePrior& prior,
                        const LocalMap& map) const;

  const SurfelMatcher& fine() const { return fine_; }
  const CorrelativeMatcher& coarse() const { return coarse_; }

 private:
  /// Near the odometry only; points of a single object leave its heading unchanged.
  ScanMatch match_few(const OrientedPoints& points,
                      const PosePrior& prior,
                      const LocalMap& map) const;
  /// Where the scan fits when the prediction is only its start: wheels may have slipped. Taken if
  /// it is the more probable of both.
  ScanMatch or_freely(const ScanMatch& near,
                      const OrientedPoints& points,
                      const PosePrior& prior,
                      const LocalMap& map) const;
  /// Negative logarithm of the posterior of a match, but for a constant.
  double cost(const ScanMatch& match, const OrientedPoints& points, const PosePrior& prior) const;
  ScanMatch match_widely(const OrientedPoints& points,
                         const SearchWindow& window,
                         const PosePrior& prior,
                         const LikelihoodPyramid& likelihood,
                         const LocalMap& map) const;
  ScanMatch judged(const SurfelMatch& fine) const;

  MatchGateOptions gates_;
  SurfelMatcher fine_;
  CorrelativeMatcher coarse_;
};

}  // namespace marco::slam
