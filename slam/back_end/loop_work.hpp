#pragma once

#include <vector>

#include "slam/back_end/graph/pose_graph.hpp"
#include "slam/back_end/loop_closer.hpp"

namespace marco::slam {

/// One search for loop closures and the optimization that follows, by value: may run on another
/// thread while scans are matched.
struct LoopWork {
  LoopCloser closer;
  std::vector<LoopCandidate> candidates;
  PoseGraph graph;      ///< as it was at the start; afterwards with the loops found
  double path_m = 0.0;  ///< driven until then
  bool robust = false;  ///< robust optimization: all loops are examined, not only the new ones
  std::vector<Loop> found = {};
  std::vector<bool> edge_is_inlier = {};  ///< of `graph`; filled by a robust optimization
  bool moved = false;                     ///< `graph` was optimized

  /// Cost: the exhaustive searches, and an optimization of the whole graph where a loop is found
  /// that does not lie where it is believed to, or where the loops have grown by a tenth since the
  /// last optimization. A robot that keeps driving through the same rooms optimizes ever more
  /// rarely.
  void run();
};

}  // namespace marco::slam
