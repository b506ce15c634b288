#pragma once

#include <cstddef>
#include <vector>

#include "common/pose2.hpp"
#include "slam/back_end/graph/pose_graph_edge.hpp"

namespace marco::slam {

struct RobustStart {
  std::vector<Pose2> poses;
  std::vector<double> weights;  ///< one an edge: 0 = a loop edge taken for wrong, else 1
};

/// A start for robust optimization, whose kernel is the truncated least squares cost: poses
/// computed from the edges alone although many loop edges are wrong: rotations first, then
/// translations given these, each a linear problem (Carlone et al., ICRA 2015) made robust by
/// graduated non-convexity with the truncated least squares cost (Yang et al., RA-L 2020). Linear
/// problems have no local minima, so that no start is needed and odometry may be as bad as it
/// likes. Loops that no other loop nearby agrees with are left out from the first on, where loops
/// are many (the idea of pairwise consistency, Mangelson et al., ICRA 2018). Solved by conjugate
/// gradients: hundreds of random loops would fill a factorization.
/// @param first  pose of node 0
/// @param loop_rejection_chi2  e^T Omega e above which a loop edge is wrong
RobustStart robust_start(const Pose2& first,
                         std::size_t nodes,
                         const std::vector<PoseGraphEdge>& edges,
                         double loop_rejection_chi2);

}  // namespace marco::slam
