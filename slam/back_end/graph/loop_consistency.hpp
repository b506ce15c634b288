#pragma once

#include <cstddef>
#include <vector>

#include "slam/back_end/graph/pose_graph_edge.hpp"

namespace marco::slam {

/// Pairwise consistency of loop closures (the idea of Mangelson et al., ICRA 2018): wrong loops are
/// rarely alone in being wrong, but they are wrong each in its own way.
/// @returns one weight an edge: 0 for a loop that no other loop nearby agrees with, else 1. All are
/// 1 where loops are few: they stand alone, and say nothing of each other.
std::vector<double> consistent_loops(std::size_t nodes, const std::vector<PoseGraphEdge>& edges);

}  // namespace marco::slam
