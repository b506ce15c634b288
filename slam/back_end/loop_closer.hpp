#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/back_end/graph/pose_graph_edge.hpp"
#include "slam/back_end/graph/relative_covariance.hpp"
#include "slam/map/keyframe.hpp"
#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/oriented_points.hpp"
#include "slam/matching/surfel_matcher.hpp"

namespace marco::slam {

struct LoopCloserOptions {
  double attempt_every_m = 0.5;  ///< of path between two searches
  double min_path_m = 8.0;       ///< a revisit lies at least this much path back
  double radius_m = 4.0;         ///< between the two places, besides the drift
  double max_drift_m = 8.0;      ///< the widest search, however unsure the pose is
  double max_drift_deg = 30.0;
  int candidates = 2;       ///< places tried at one search
  int around = 4;           ///< keyframes before and after each place that are matched together
  double min_score = 0.50;  ///< of the exhaustive search
  /// Taken from that score where a place lies as far off as it may: of places that look alike, as
  /// along a corridor, the one is believed that drift explains best.
  double unlikely_penalty = 0.25;
  double min_overlap = 0.80;  ///< of the fine match, among what the earlier visit could see
  double sigma_m = 0.02;      ///< added to the fine match's own uncertainty
  double sigma_deg = 0.3;

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("attempt_every_m", attempt_every_m, kNotNegative,
               "Distance driven between two searches for loop closures. More to save time.");
    v.advanced("min_path_m", min_path_m, kPositive,
               "A loop closure needs at least this much path since the earlier visit.");
    v.advanced(
        "radius_m", radius_m, kPositive,
        "Earlier keyframes within this distance, beyond the expected drift, are candidates.");
    v("max_drift_m", max_drift_m, kPositive,
      "Largest drift that the search allows for. More for kilometres without a revisit.");
    v.advanced("max_drift_deg", max_drift_deg, Limits{0.0, 180.0},
               "Largest drift in heading that the search allows for.");
    v.advanced("min_score", min_score, Limits{0.0, 1.0},
               "Candidates with a lower score in the exhaustive search are rejected.");
    v.advanced("min_overlap", min_overlap, Limits{0.0, 1.0},
               "A loop closure needs this fraction of the points that the earlier visit could see "
               "on its walls. Less where furniture has moved.");
  }
};

/// A loop closure: two keyframes of one place, and the evidence for it.
struct Loop {
  int from = 0;  ///< the older keyframe
  int to = 0;
  Pose2 from_from_to;
  Pose2 believed = {};  ///< where `to` was seen from `from` before
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< frame of `to`
  double score = 0.0;                                         ///< of the exhaustive search, 0..1
  double overlap = 0.0;                                       ///< of the fine match, 0..1
  double shift_m = 0.0;  ///< how far it would move the newer scan
  double turn_deg = 0.0;
  bool is_inlier = true;  ///< false: the pose graph found that it contradicts the rest

  PoseGraphEdge edge() const { return {from, to, from_from_to, information, true}; }

  template <class Visitor>
  void visit(Visitor& v) {
    v("from", from);
    v("to", to);
    v("from_from_to", from_from_to);
    v("believed", believed);
    v("information", information);
    v("score", score);
    v("overlap", overlap);
    v("shift_m", shift_m);
    v("turn_deg", turn_deg);
    v("is_inlier", is_inlier);
  }
};

/// Two places that may be one: all that verify() depends on, by value.
struct LoopCandidate {
  int from = 0;
  int to = 0;
  Pose2 world_from_old;
  Pose2 world_from_newest;
  OrientedPoints place;  ///< around the older keyframe, world
  OrientedPoints seen;   ///< around the newest one, in its frame
  /// How well the newest one's pose is known, seen from the older one; frame of the newest.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::vector<Keyframe> place_keys;  ///< some of the place's: what they could see
};

/// Of a path whose own uncertainty is not to be trusted: the newest keyframe's pose is as unsure as
/// the bias over the path driven makes it.
std::vector<RelativeUncertainty> uncertainties_by_path(const std::vector<Keyframe>& keys);

/// Loop closure: finds out whether the newest keyframe shows a place seen before. Candidates by
/// distance and by how well the graph knows it, an exhaustive search in that window, a fine match;
/// the last keyframes are matched together, since one scan of a corridor looks like another. What
/// the earlier visit could not see is left out of the match: it would pull the walls onto the part
/// of them that was seen. A wide window may hold a rival that fits as well: then nothing is
/// believed. Const: safe from several threads.
class LoopCloser {
 public:
  LoopCloser(const LoopCloserOptions& options,
             const CorrelativeMatcher& coarse,
             const SurfelMatcher& fine);

  /// @param keys  with their present poses; the last one is the newest
  /// @param uncertainties  of the newest keyframe's pose, seen from each
  /// @param closed_path_m  path driven when a loop was last closed; 0 = never
  std::vector<Loop> find(const std::vector<Keyframe>& keys,
                         const std::vector<RelativeUncertainty>& uncertainties,
                         double closed_path_m) const;

  /// find() in two steps: candidates() is quick and copies what verify() needs; verify() takes
  /// long.
  std::vector<LoopCandidate> candidates(const std::vector<Keyframe>& keys,
                                        const std::vector<RelativeUncertainty>& uncertainties,
                                        double closed_path_m) const;
  /// Whether any older keyframe is near enough to the newest one for candidates(), however little
  /// is known of its pose. Quick.
  bool may_have_candidates(const std::vector<Keyframe>& keys) const;
  /// Of a position, x and y together: from there on a search is as wide as it may be.
  double max_variance_m2() const;
  std::optional<Loop> verify(const LoopCandidate& candidate) const;

  const LoopCloserOptions& options() const { return options_; }

  /// How far a search reaches, of a pose known so well.
  double shift_m(const Eigen::Matrix3d& covariance) const;

 private:
  double turn_rad(const Eigen::Matrix3d& covariance) const;
  /// The nearest keyframes of the stretches of path that pass near the newest one.
  std::vector<int> nearby_places(const std::vector<Keyframe>& keys,
                                 const std::vector<Eigen::Matrix3d>& covariances) const;
  /// Whether another place in the window fits as well.
  bool has_rival(const LikelihoodPyramid& likelihood,
                 const LoopCandidate& candidate,
                 const SearchWindow& window,
                 const CorrelativeMatch& best,
                 const Eigen::Matrix3d& information) const;

  LoopCloserOptions options_;
  CorrelativeMatcher coarse_;
  SurfelMatcher fine_;
};

}  // namespace marco::slam
