#pragma once

#include <vector>

#include "slam/back_end/graph/pose_graph_edge.hpp"

namespace marco::slam {

/// The shortest way [m] along the edges from one node to each, either direction (Dijkstra 1959);
/// infinite where none leads. How far the poses of two nodes may be off depends on it, not on the
/// path that was driven from one to the other: loops are short cuts (Bosse et al., IJRR 2004, sec.
/// 3: uncertainty along the shortest way through a graph of maps).
/// @param node_count  nodes are 0 .. node_count - 1. @throws std::out_of_range for a node beyond.
/// Cost O(edges log nodes).
std::vector<double> shortest_path_lengths_m(int from,
                                            int node_count,
                                            const std::vector<PoseGraphEdge>& edges);

}  // namespace marco::slam
