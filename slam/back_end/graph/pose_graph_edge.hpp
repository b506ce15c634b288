#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/pose2.hpp"

namespace marco::slam {

/// A measured pose of node `to` seen from node `from`.
struct PoseGraphEdge {
  int from = 0;
  int to = 0;
  Pose2 from_from_to;
  Eigen::Matrix3d information =
      Eigen::Matrix3d::Identity();  ///< of (x, y, theta) in `from_from_to`'s frame
  bool is_loop =
      false;  ///< may be wrong: such edges are weighed by how well they agree with the rest

  template <class Visitor>
  void visit(Visitor& v) {
    v("from", from);
    v("to", to);
    v("from_from_to", from_from_to);
    v("information", information);
    v("is_loop", is_loop);
  }
};

/// e = (R_z^T (R_i^T (t_j - t_i) - t_z), theta_j - theta_i - theta_z), in the measurement's frame.
Eigen::Vector3d edge_error(const PoseGraphEdge& edge, const Pose2& from, const Pose2& to);

/// d e / d (x, y, theta) of both nodes, for increments in the world frame.
struct EdgeJacobians {
  Eigen::Matrix3d from;
  Eigen::Matrix3d to;
};
EdgeJacobians edge_jacobians(const PoseGraphEdge& edge, const Pose2& from, const Pose2& to);

class SparseNormalEquations;

/// What an optimization may change.
enum class Moves { poses, translations };

/// Adds J^T (weight * information) J and J^T (weight * information) e of one edge between two of
/// `poses`.
void add_edge_to(SparseNormalEquations& equations,
                 const PoseGraphEdge& edge,
                 const std::vector<Pose2>& poses,
                 double weight,
                 Moves moves = Moves::poses);

}  // namespace marco::slam
