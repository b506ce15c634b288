#pragma once

#include <vector>

#include "common/trajectory.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/doctor/diagnosis.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// One recording's path, and its raw odometry where there was any, in the order of the scans.
struct RecordedPath {
  Trajectory path;
  Trajectory odometry;
};

/// What a map holds after its last optimization.
struct MapEvidence {
  std::vector<Keyframe> keys;
  std::vector<PoseGraphEdge> edges;  ///< none where the map is made without a pose graph
  std::vector<Loop> loops;           ///< one a loop edge, in their order
  std::vector<RecordedPath> paths;
  int scans = 0;          ///< level ones that got a pose and could be matched; 0 of a line SLAM
  int matched_scans = 0;  ///< of them, those that were laid on the map
  int blind_scans = 0;    ///< level ones that got a pose and saw too little to be matched

  /// Counts a scan of the scan SLAM. @param hits  its returns, @param min_points  fewer are too few
  void count(int hits, bool is_level, bool is_matched, int min_points) {
    if (!is_level) return;
    ++(hits < min_points ? blind_scans : scans);
    matched_scans += is_matched ? 1 : 0;
  }
};

/// Finds out whether a map is to be believed, without truth: by what its own scans, loops and
/// odometry say of each other. A pure function. Blind to a map that is bent where it was seen once
/// and without odometry; a place that was rebuilt between two passes looks like a wrong map.
/// Cost O(keyframes * points) and a factorization of the graph; a search more for each reason.
Diagnosis examine(const MapEvidence& map);

}  // namespace marco::slam
