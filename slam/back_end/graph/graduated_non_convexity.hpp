#pragma once

#include <vector>

#include "slam/back_end/graph/pose_graph_edge.hpp"

namespace marco::slam {

/// Weights of graduated non-convexity with the truncated least squares cost (Yang et al., RA-L
/// 2020, eq. 14) for squared residuals `chi2` of the loop edges; the others keep theirs.
/// @returns whether some are still undecided.
bool graduate(const std::vector<PoseGraphEdge>& edges,
              const std::vector<double>& chi2,
              double limit,
              double mu,
              std::vector<double>& weights);

/// The mu to start with, at which the surrogate is convex; 0 when no loop exceeds the limit.
double first_mu(const std::vector<PoseGraphEdge>& edges,
                const std::vector<double>& chi2,
                double limit);

}  // namespace marco::slam
