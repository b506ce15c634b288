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

}  // namespace loop_gates

// clang-format off
/// Every rule that decides whether a loop closure is believed.
inline constexpr Gate kLoopGates[] = {
    {"no revisit", "path since the earlier visit [m], less than", LoopCloserOptions{}.min_path_m, "not searched", "slam.loops.min_path_m; after a shorter path it is the same visit"},
    {"coarse score", "score of the exhaustive search, less than", LoopCloserOptions{}.min_score, "no loop", "slam.loops.min_score"},
    {"unlikely place", "penalty on the score of a place at the limit of the drift", LoopCloserOptions{}.unlikely_penalty, "the place that drift explains best wins", "assumed"},
    {"fine overlap", "overlap of the fine match among the points that the earlier visit could see, less than", LoopCloserOptions{}.min_overlap, "no loop", "slam.loops.min_overlap; with 0.6 of all points: 2 km through one building: 77 % recalled and 205 false loops, instead of 95 % and 1"},
    {"rival", "score margin over another place, less than", loop_gates::kRivalMargin, "no loop, if the match claims certainty that it is not that place", "assumed"},
    {"rival", "distance of that place [m], at least", loop_gates::kRivalM, "counts as another place", "assumed"},
    {"rival", "or its rotation [deg], at least", loop_gates::kRivalDeg, "counts as another place", "assumed"},
    {"contradicts the graph", "squared Mahalanobis distance from the rest of the pose graph, more than", PoseGraphOptions{}.loop_rejection_chi2, "rejected", "slam.graph.loop_rejection_chi2; the 99.9 % quantile of chi-squared, 3 degrees of freedom"},
};
// clang-format on

}  // namespace marco::slam
