#pragma once

#include "common/gate.hpp"
#include "slam/back_end/graph/pose_graph.hpp"
#include "slam/back_end/loop_closer.hpp"

namespace marco::slam {

namespace loop_gates {

// Another place is a rival when its score comes this near, it lies this far away, and the match
// claims to know that it is not there.
inline constexpr double kRivalMargin = 0.05;
inline constexpr double kRivalM = 0.5, kRivalDeg = 10.0;

// Part of the points that lie where the other visit saw free space.
inline constexpr double kContradicted = 0.30;

// A loop that moves the newest keyframe less lies within what counts as a wall (RangeView).
inline constexpr double kMovesM = 0.15;
// Standard deviations of what chance explains, where neighbouring points are correlated.
inline constexpr double kSurelyBetterSigmas = 2.0;

}  // namespace loop_gates

// clang-format off
/// Every rule that decides whether a loop closure is believed.
inline constexpr Gate kLoopGates[] = {
    {"no revisit", "path since the earlier visit [m], less than", LoopCloserOptions{}.min_path_m, "not searched", "slam.loops.min_path_m; a shorter way back is the same visit"},
    {"coarse score", "score of the exhaustive search, less than", LoopCloserOptions{}.min_score, "no loop", "slam.loops.min_score"},
    {"unlikely place", "taken from the score where a place lies as far off as drift may be", LoopCloserOptions{}.unlikely_penalty, "the place that drift explains best is believed", "assumed"},
    {"fine overlap", "overlap of the fine match, less than", LoopCloserOptions{}.min_overlap, "no loop", "slam.loops.min_overlap"},
    {"rival", "score by which another place is worse, less than", loop_gates::kRivalMargin, "no loop, where the match claims to know that it is not there", "assumed"},
    {"rival", "distance of that place [m], at least", loop_gates::kRivalM, "taken for another place", "assumed"},
    {"rival", "or its turn [deg], at least", loop_gates::kRivalDeg, "taken for another place", "assumed"},
    {"free space", "part of the points that lie where the other visit saw free space, more than", loop_gates::kContradicted, "no loop, and no rival", "the doctor's: doors, chairs and panes reach 0.25"},
    {"path agrees better", "how far the match moves the newest keyframe [m], more than", loop_gates::kMovesM, "with the next row: no loop", "what counts as on a wall"},
    {"path agrees better: chance", "contradicted part of what both visits see, less at the path's pose by more standard deviations than", loop_gates::kSurelyBetterSigmas, "with the row before: no loop", "without it: two of ten drives to ten stops in an office, path off by 0.04 and 0.07 instead of 0.004 and 0.003 m"},
    {"contradicts the graph", "squared Mahalanobis distance from the rest of the pose graph, more than", PoseGraphOptions{}.loop_rejection_chi2, "not in force", "slam.graph.loop_rejection_chi2; the 99.9 % quantile of chi-squared, 3 degrees of freedom"},
};
// clang-format on

}  // namespace marco::slam
