#pragma once

#include <vector>

#include "slam/back_end/graph/pose_graph_edge.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/map/keyframe_culling.hpp"

namespace marco::slam {

/// Marginalization: removes a merged keyframe's node from the graph. Its edges are moved to the
/// node that it was merged into, with the uncertainty of the merge added, in place of the dense
/// edges that an exact marginalization would leave. Of two edges of one kind between the same nodes
/// the older stays, and of loops two a node.
/// @param loops  one for each loop edge, in their order
void merge_nodes(int key,
                 const MergedKeyframe& merged,
                 std::vector<PoseGraphEdge>& edges,
                 std::vector<Loop>& loops);

}  // namespace marco::slam
