#include "slam/back_end/graph/edge_judgement.hpp"

#include <algorithm>
#include <limits>

#include "common/linear_algebra.hpp"
#include "slam/back_end/graph/selected_inverse.hpp"
#include "slam/back_end/graph/sparse_normal_equations.hpp"

namespace marco::slam {
namespace {

// An edge left out that exceeds its limit by this factor is skipped.
constexpr double kSkipFactor = 1000.0;

// Covariance of an edge's error by what all edges in force say of its two nodes; node 0 is known.
// Where the edge itself is in force the inverse has all that is needed ...
Eigen::Matrix3d predicted_covariance(const SelectedInverse& inverse,
                                     const PoseGraphEdge& edge,
                                     const EdgeJacobians& jacobians) {
  const auto block = [&inverse](int row_node, int column_node) {
    Eigen::Matrix3d result = Eigen::Matrix3d::Zero();
    if (row_node == 0 || column_node == 0) return result;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        result(r, c) = inverse.at(3 * (row_node - 1) + r, 3 * (column_node - 1) + c);
      }
    }
    return result;
  };
  const Eigen::Matrix3d across =
      jacobians.from * block(edge.from, edge.to) * jacobians.to.transpose();
  return jacobians.from * block(edge.from, edge.from) * jacobians.from.transpose() +
         jacobians.to * block(edge.to, edge.to) * jacobians.to.transpose() + across +
         across.transpose();
}

// ... and else not.
Eigen::Matrix3d predicted_covariance(const SparseSolver& solver,
                                     const PoseGraphEdge& edge,
                                     const EdgeJacobians& jacobians) {
  Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(solver.cols(), 3);
  if (edge.from > 0)
    turned.middleRows<3>(3 * Eigen::Index{edge.from - 1}) = jacobians.from.transpose();
  if (edge.to > 0) turned.middleRows<3>(3 * Eigen::Index{edge.to - 1}) = jacobians.to.transpose();
  return turned.transpose() * solver.solve(turned);
}

// Squared Mahalanobis distance of an edge's error from what all others say: of an edge in force
// exactly what leaving it out would give. With W^T W = Omega and L = W P W^T it is
// (W e)^T (I -+ L)^-1 (W e): Omega may be singular, as where a loop knows only one direction.
double surprise(const Eigen::Matrix3d& information,
                const Eigen::Matrix3d& predicted,
                const Eigen::Vector3d& error,
                bool in_force) {
  const auto [squares, axes] = eigenpairs_of(information);
  const Eigen::Matrix3d root = squares.cwiseMax(0.0).cwiseSqrt().asDiagonal() * axes.transpose();
  const auto [leverage, vectors] =
      eigenpairs_of(Eigen::Matrix3d(root * predicted * root.transpose()));
  const Eigen::Vector3d whitened = vectors.transpose() * (root * error);
  // A direction that only this edge knows cannot contradict it.
  constexpr double kAlone = 1e-6;
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double part = std::max(0.0, leverage[i]);
    if (in_force && part > 1.0 - kAlone) continue;
    sum += whitened[i] * whitened[i] / (in_force ? 1.0 - part : 1.0 + part);
  }
  return sum;
}

}  // namespace

Eigen::Matrix3d relative_covariance(const PoseGraph& graph,
                                    const std::vector<double>& weights,
                                    int from,
                                    int to) {
  SparseNormalEquations equations(graph.node_count());
  graph.fill(equations, weights, Moves::poses);
  const SparseSolver solver(equations.hessian());
  if (solver.info() != Eigen::Success) {
    return std::numeric_limits<double>::infinity() * Eigen::Matrix3d::Identity();
  }
  const Pose2& from_pose = graph.poses()[static_cast<std::size_t>(from)];
  const Pose2& to_pose = graph.poses()[static_cast<std::size_t>(to)];
  const PoseGraphEdge ends{from, to, between(from_pose, to_pose), Eigen::Matrix3d::Zero(), false};
  return predicted_covariance(solver, ends, edge_jacobians(ends, from_pose, to_pose));
}

std::vector<EdgeJudgement> judge_edges(const PoseGraph& graph,
                                       const std::vector<bool>& in_force,
                                       JudgedEdges judged,
                                       double limit) {
  std::vector<EdgeJudgement> result(graph.edges().size());
  SparseNormalEquations equations(graph.node_count());
  graph.fill(equations, std::vector<double>(in_force.begin(), in_force.end()), Moves::poses);
  Eigen::SparseMatrix<double> hessian = equations.hessian();
  hessian.diagonal() = hessian.diagonal().cwiseMax(1e-9).eval();
  const SparseSolver solver(hessian);
  if (solver.info() != Eigen::Success) return result;
  const SelectedInverse inverse(solver);
  for (std::size_t i = 0; i < graph.edges().size(); ++i) {
    const PoseGraphEdge& edge = graph.edges()[i];
    if (!edge.is_loop && judged == JudgedEdges::loops) continue;
    if (!in_force[i] && graph.edge_chi2(edge) > kSkipFactor * limit) {
      result[i].squared_distance = kSkipFactor * limit;
      continue;
    }
    const Pose2& from = graph.poses()[static_cast<std::size_t>(edge.from)];
    const Pose2& to = graph.poses()[static_cast<std::size_t>(edge.to)];
    const EdgeJacobians jacobians = edge_jacobians(edge, from, to);
    result[i].covariance = in_force[i] ? predicted_covariance(inverse, edge, jacobians)
                                       : predicted_covariance(solver, edge, jacobians);
    result[i].squared_distance =
        surprise(edge.information, result[i].covariance, edge_error(edge, from, to), in_force[i]);
  }
  return result;
}

}  // namespace marco::slam
