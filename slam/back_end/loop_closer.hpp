#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/back_end/graph/pose_graph_edge.hpp"
#include "slam/map/keyframe.hpp"
#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/oriented_points.hpp"
#include "slam/matching/surfel_matcher.hpp"

namespace marco::slam {

struct LoopCloserOptions {
  double attempt_every_m = 0.5;  ///< of path between two searches
  double min_path_m = 8.0;       ///< a revisit lies at least this much path back
  double radius_m = 4.0;         ///< between the two places, beside the drift
  double drift_m = 0.3;          ///< how far the path may be off: this ...
  double drift_m_per_m = 0.03;   ///< ... this much of the path since a loop was last closed ...
  double closed_drift_m_per_m = 0.005;  ///< ... and this much of the way before, over its loops
  double max_drift_m = 4.0;
  double drift_deg = 4.0;
  double drift_deg_per_m = 0.3;
  double max_drift_deg = 30.0;
  int candidates = 2;       ///< places tried at one search
  int around = 4;           ///< keyframes before and after each place that are matched together
  double min_score = 0.50;  ///< of the exhaustive search
  /// Taken from that score where a place lies as far off as it may: of places that look alike, as
  /// along a corridor, the one is believed that drift explains best.
  double unlikely_penalty = 0.25;
  double min_overlap = 0.60;  ///< of the fine match
  double sigma_m = 0.02;      ///< added to the fine match's own uncertainty
  double sigma_deg = 0.3;

  template <class Visitor>
  void visit(Visitor& v) {
    v("attempt_every_m", attempt_every_m, kNotNegative);
    v("min_path_m", min_path_m, kPositive);
    v("radius_m", radius_m, kPositive);
    v("drift_m", drift_m, kPositive);
    v("drift_m_per_m", drift_m_per_m, kNotNegative);
    v("closed_drift_m_per_m", closed_drift_m_per_m, kNotNegative);
    v("max_drift_m", max_drift_m, kPositive);
    v("drift_deg", drift_deg, kPositive);
    v("drift_deg_per_m", drift_deg_per_m, kNotNegative);
    v("max_drift_deg", max_drift_deg, Limits{0.0, 180.0});
    v("candidates", candidates, Limits{1, 100});
    v("around", around, Limits{0, 100});
    v("min_score", min_score, Limits{0.0, 1.0});
    v("unlikely_penalty", unlikely_penalty, Limits{0.0, 1.0});
    v("min_overlap", min_overlap, Limits{0.0, 1.0});
    v("sigma_m", sigma_m, kPositive);
    v("sigma_deg", sigma_deg, kPositive);
  }
};

/// A loop closure: two keyframes of one place, and the evidence for it.
struct Loop {
  int from = 0;  ///< the older keyframe
  int to = 0;
  Pose2 from_from_to;
  Pose2 believed = {};  ///< where `to` was seen from `from` before
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< frame of `from`
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
  double shift_m = 0.0;  ///< how far the newest may be off
  double turn_rad = 0.0;
};

/// Loop closure: finds out whether the newest keyframe shows a place seen before. Candidates by
/// distance and drift, an exhaustive search in the window that the drift allows, a fine match; the
/// last keyframes are matched together, since one scan of a corridor looks like another. Const:
/// safe from several threads.
class LoopCloser {
 public:
  LoopCloser(const LoopCloserOptions& options,
             const CorrelativeMatcher& coarse,
             const SurfelMatcher& fine);

  /// @param keys  with their present poses; the last one is the newest
  /// @param closed_path_m  path driven when a loop was last closed; 0 = never
  std::vector<Loop> find(const std::vector<Keyframe>& keys, double closed_path_m) const;

  /// find() in two steps: candidates() is quick and copies what verify() needs; verify() takes
  /// long.
  /// @param shortest_path_lengths_m  along the graph from the newest keyframe to each
  /// (shortest_paths.hpp): drift grows with these; empty = with the path driven
  std::vector<LoopCandidate> candidates(
      const std::vector<Keyframe>& keys,
      double closed_path_m,
      const std::vector<double>& shortest_path_lengths_m = {}) const;
  std::optional<Loop> verify(const LoopCandidate& candidate) const;

  const LoopCloserOptions& options() const { return options_; }

 private:
  struct Drift {
    double shift_m;
    double turn_rad;
  };
  Drift drift(double way_m, double since_closed_m) const;
  /// The nearest keyframes of the stretches of path that pass near the newest one.
  std::vector<int> nearby_places(const std::vector<Keyframe>& keys,
                                 const std::vector<double>& shortest_path_lengths_m,
                                 double since_closed_m) const;

  LoopCloserOptions options_;
  CorrelativeMatcher coarse_;
  SurfelMatcher fine_;
};

}  // namespace marco::slam
