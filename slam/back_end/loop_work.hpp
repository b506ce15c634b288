#pragma once

#include <vector>

#include "slam/back_end/graph/pose_graph.hpp"
#include "slam/back_end/loop_closer.hpp"

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
  bool moved = false;                    ///< `graph` was optimized

  /// Cost: the exhaustive searches; and an optimization of the whole graph where a loop is found
  /// that does not lie where it is believed to, or a tenth more loops are known than at the last
  /// such. So a robot that goes on driving through the same rooms optimizes ever more rarely.
  void run();
};

}  // namespace marco::slam
