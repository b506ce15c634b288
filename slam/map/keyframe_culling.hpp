#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/back_end/graph/pose_graph_edge.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/matching/surfel_matcher.hpp"

namespace marco::slam {

struct ThinningOptions {
  int after_keys = 1000;  ///< more keyframes than were kept the last time: looked through again
  int recent_keys = 200;  ///< the last ones wait: a wrong loop may not have been contradicted yet
  int keys_a_place = 1;   ///< so many keyframes see a place before another becomes one with them
  double near_m = 0.5;    ///< they are of one place when so near ...
  double near_turn_deg = 25;  ///< ... and turned so little; neighbours: half of both
  double min_overlap = 0.80;  ///< of the match that ties it to them: else it saw something new
  double max_shift_m = 0.10;  ///< by which that match may move it: else the loop is not closed yet
  double max_turn_deg = 1.5;

  template <class Visitor>
  void visit(Visitor& v) {
    v("after_keys", after_keys, Limits{1, 1000000});
    v("recent_keys", recent_keys, Limits{0, 1000000});
    v("keys_a_place", keys_a_place, Limits{1, 1000000});
    v("near_m", near_m, kPositive);
    v("near_turn_deg", near_turn_deg, kPositive);
    v("min_overlap", min_overlap, Limits{0.0, 1.0});
    v("max_shift_m", max_shift_m, kPositive);
    v("max_turn_deg", max_turn_deg, kPositive);
  }
};

/// A keyframe that becomes one with an older one.
struct MergedKeyframe {
  int into = 0;
  Pose2 into_from_key;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta), frame of the key
};

/// Where a keyframe adds nothing to older ones of its place, so that what is kept grows with the
/// area and not with the time: enough of them stand there and look the same way, and it matches
/// them where the pose graph says that it is. One that matches them badly saw something new and is
/// kept beside them, up to three times as many.
/// @param key  index; only keyframes before it are looked at. Cost: their number, and a match.
/// @param loop_closed  loops were found on both sides of it; until then only those of the same
/// pass are known to be where it is
std::optional<MergedKeyframe> seen_before(const std::vector<Keyframe>& keys,
                                          int key,
                                          bool loop_closed,
                                          const SurfelMatcher& matcher,
                                          const ThinningOptions& options);

/// The graph without that node: what was measured from it was measured from the other one, that
/// much less surely; of two edges of one kind between the same nodes the older stays, and of loops
/// two a node.
/// @param loops  one a loop edge, in their order
void merge_nodes(int key,
                 const MergedKeyframe& merged,
                 std::vector<PoseGraphEdge>& edges,
                 std::vector<Loop>& loops);

}  // namespace marco::slam
