#pragma once

#include <optional>

#include "slam/map/keyframe.hpp"
#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/surfel_matcher.hpp"

namespace marco::slam {

struct LocalMapOptions {
  int window_keyframes = 15;  ///< the local map is made of this many last keyframes ...
  int window_slack = 5;       ///< ... and up to this many more; then it is rebuilt

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("window_keyframes", window_keyframes, Limits{1, 1000},
               "Number of recent keyframes in the local map. More for a narrow field of view.");
  }
};

/// The local map, or submap: what scans are matched against, made of the last keyframes. Which
/// these are depends on how many keyframes were ever made, and on nothing else. Not thread-safe.
class LocalMap {
 public:
  LocalMap(const LocalMapOptions& options,
           const SurfelMatcherOptions& surfels,
           const CorrelativeMatcherOptions& likelihood);

  bool empty() const { return !surfels_; }
  /// Adds the newest keyframe; rebuilds where the window is full.
  /// @returns see SurfelMap::add()
  double extend(const KeyframeSet& keyframes);
  /// After keyframes have moved. @param keyframes  at least one
  double rebuild(const KeyframeSet& keyframes);
  /// As a saved one was. @param centre_m  its centre_m()
  void restore(const KeyframeSet& keyframes, const Eigen::Vector2d& centre_m);
  /// After a keyframe was merged.
  void drop_likelihood() { likelihood_.reset(); }

  /// Only when not empty().
  const SurfelPyramid& surfels() const { return *surfels_; }
  /// For the exhaustive search; of the last keyframes where they lie now. Made when first asked
  /// for.
  const LikelihoodPyramid& likelihood(const KeyframeSet& keyframes);
  Eigen::Vector2d centre_m() const;

 private:
  /// The first keyframe of the window, counted in all ever made.
  int first_of(const KeyframeSet& keyframes) const;
  double fill(const KeyframeSet& keyframes, const Eigen::Vector2d& centre_m);

  LocalMapOptions options_;
  SurfelMatcherOptions surfel_options_;
  CorrelativeMatcherOptions likelihood_options_;
  std::optional<SurfelPyramid> surfels_;
  std::optional<LikelihoodPyramid> likelihood_;
  int first_ = 0;  ///< as first_of()
};

}  // namespace marco::slam
