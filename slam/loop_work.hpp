#pragma once

#include <vector>

#include "slam/graph/pose_graph.hpp"
#include "slam/loop_closer.hpp"

namespace marco::slam {

/// One look for loops and the optimization that follows, by value: may run on another thread while
/// scans go on being matched.
struct LoopWork {
  LoopCloser closer;
  std::vector<LoopQuestion> questions;
  PoseGraph graph;           ///< as it was when asked; afterwards with what was found
  double path_m = 0.0;       ///< driven until then
  bool doubt_loops = false;  ///< all loops are asked whether they agree, not only the new ones made
  std::vector<Loop> found = {};
  std::vector<bool> edge_in_force = {};  ///< of `graph`; filled when in doubt

  /// Cost: the exhaustive searches, and where a loop is found an optimization of the whole graph.
  void run();
};

}  // namespace marco::slam
