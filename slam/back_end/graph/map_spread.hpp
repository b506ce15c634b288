#pragma once

#include <vector>

#include "slam/back_end/graph/pose_graph.hpp"

namespace marco::slam {

/// How far a part of the map is off as a whole by what the edges leave open: drawings from the
/// normal distribution of the poses given the edges, to first order at the present poses (x = P^T
/// L^-T D^-1/2 z of the factored normal equations; Rue 2001, algorithm 1), each laid on the map by
/// the rigid motion that fits best.
/// @param weights  one an edge, 0 = not in force
/// @param part  of the nodes, 0..1, that are off by more
/// @returns the median over the drawings of how far [m] that part is off; infinite where the graph
/// is singular. The drawings are the same in every run.
double map_spread_m(const PoseGraph& graph, const std::vector<double>& weights, double part);

}  // namespace marco::slam
