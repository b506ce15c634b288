#include "slam/back_end/graph/pose_graph_edge.hpp"

#include "slam/back_end/graph/sparse_normal_equations.hpp"

namespace marco::slam {

Eigen::Vector3d edge_error(const PoseGraphEdge& edge, const Pose2& from, const Pose2& to) {
  return (edge.from_from_to.inverse() * between(from, to)).vector();
}

EdgeJacobians edge_jacobians(const PoseGraphEdge& edge, const Pose2& from, const Pose2& to) {
  const Eigen::Matrix2d edge_from_world =
      (from.rotation() * edge.from_from_to.rotation()).transpose();
  const double dx = to.x_m - from.x_m, dy = to.y_m - from.y_m;
  EdgeJacobians jacobians;
  jacobians.from.setZero();
  jacobians.from.topLeftCorner<2, 2>() = -edge_from_world;
  jacobians.from.topRightCorner<2, 1>() = edge_from_world * Eigen::Vector2d(dy, -dx);
  jacobians.from(2, 2) = -1.0;
  jacobians.to.setZero();
  jacobians.to.topLeftCorner<2, 2>() = edge_from_world;
  jacobians.to(2, 2) = 1.0;
  return jacobians;
}

void add_edge_to(SparseNormalEquations& equations,
                 const PoseGraphEdge& edge,
                 const std::vector<Pose2>& poses,
                 double weight,
                 Moves moves) {
  const Pose2& from = poses[static_cast<std::size_t>(edge.from)];
  const Pose2& to = poses[static_cast<std::size_t>(edge.to)];
  const Eigen::Vector3d error = edge_error(edge, from, to);
  EdgeJacobians j = edge_jacobians(edge, from, to);
  if (moves == Moves::translations) {
    j.from.col(2).setZero();
    j.to.col(2).setZero();
  }
  const Eigen::Matrix3d information = weight * edge.information;
  equations.add_block(edge.from, edge.from, j.from.transpose() * information * j.from);
  equations.add_block(edge.to, edge.to, j.to.transpose() * information * j.to);
  equations.add_block(edge.from, edge.to, j.from.transpose() * information * j.to);
  equations.add_gradient(edge.from, j.from.transpose() * information * error);
  equations.add_gradient(edge.to, j.to.transpose() * information * error);
}

}  // namespace marco::slam
