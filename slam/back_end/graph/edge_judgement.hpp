#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/back_end/graph/pose_graph.hpp"

namespace marco::slam {

/// What the graph says of one of its edges, to first order at the present poses.
struct EdgeJudgement {
  /// Mahalanobis distance, squared, of its error from what all others say: of an edge in force what
  /// leaving it out would give. 3 degrees of freedom; 0 for a direction that only this edge knows.
  double squared_distance = 0.0;
  /// Of the relative pose of its ends, by all edges in force, in the measurement's frame.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

enum class JudgedEdges { loops, all };

/// @param in_force  one an edge. @param limit  an edge out of force that exceeds it a thousand
/// times is not looked at closely.
/// @returns one an edge; zeros for those not asked for, and for all where the graph is singular.
std::vector<EdgeJudgement> judge_edges(const PoseGraph& graph,
                                       const std::vector<bool>& in_force,
                                       JudgedEdges judged,
                                       double limit);

/// Covariance of node `to` seen from node `from`, by the edges' weights.
/// @returns infinite variances where the graph is singular.
Eigen::Matrix3d relative_covariance(const PoseGraph& graph,
                                    const std::vector<double>& weights,
                                    int from,
                                    int to);

}  // namespace marco::slam
