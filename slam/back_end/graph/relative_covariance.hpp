#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/back_end/graph/pose_graph_edge.hpp"

namespace marco::slam {

/// How well one node's pose is known, seen from another.
struct RelativeUncertainty {
  /// Of (x, y, theta), in the frame of the node seen.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double way_m = 0.0;  ///< length of the way through the graph
};

/// How well a node's pose is known, seen from each other node, along the way through the graph that
/// knows the position best. Other ways are left out, so that it is never too small by them (Bosse
/// et al., IJRR 2004, sec. 3: uncertainty along the shortest way through a graph of maps; here the
/// length is the variance of the position). The search is Dijkstra's (1959): each edge adds its
/// covariance, carried to the node.
///
/// @param node  seen from all others
/// @param poses  of all nodes, where they lie now
/// @param max_variance_m2  of the position, x and y together: nodes beyond are not reached
/// @returns one a node; where no way leads, or only a longer one, that variance, a standard
/// deviation of half a turn, and no length. @throws std::out_of_range for a node that is not there.
/// Cost O(edges log nodes) of those reached.
std::vector<RelativeUncertainty> relative_uncertainties(int node,
                                                        const std::vector<Pose2>& poses,
                                                        const std::vector<PoseGraphEdge>& edges,
                                                        double max_variance_m2);

}  // namespace marco::slam
