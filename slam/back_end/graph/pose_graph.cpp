#include "slam/back_end/graph/pose_graph.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "slam/back_end/graph/loop_choice.hpp"
#include "slam/back_end/graph/sparse_normal_equations.hpp"

namespace marco::slam {
namespace {

// [chi2] far below what any measurement can tell: the error of an exact graph.
constexpr double kNoError = 1e-12;

// A step whose gain differs from the linear prediction by more than this part of it went along
// a bend.
constexpr double kAsPredicted = 0.1;

using SparseMatrix = Eigen::SparseMatrix<double>;
using Solver = Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower>;

}  // namespace

PoseGraph::PoseGraph(const PoseGraphOptions& options) : options_(options) {
  validate(options, "pose_graph");
}

int PoseGraph::add_node(const Pose2& world_from_node) {
  require(is_finite(world_from_node), "PoseGraph: a node's pose is not finite");
  poses_.push_back(world_from_node);
  return static_cast<int>(poses_.size()) - 1;
}

void PoseGraph::add_edge(const PoseGraphEdge& edge) {
  const auto exists = [this](int node) {
    return node >= 0 && static_cast<std::size_t>(node) < poses_.size();
  };
  require(exists(edge.from) && exists(edge.to) && edge.from != edge.to,
          "PoseGraph: an edge needs two different nodes that exist");
  require(is_finite(edge.from_from_to), "PoseGraph: an edge's measurement is not finite");
  require(is_semidefinite(edge.information),
          "PoseGraph: an edge's information matrix has a negative eigenvalue");
  edges_.push_back(edge);
}

void PoseGraph::remove_node(int node) {
  require(node >= 0 && static_cast<std::size_t>(node) < poses_.size(),
          "PoseGraph: no such node to remove");
  poses_.erase(poses_.begin() + node);
  edges_.clear();
}

double PoseGraph::edge_chi2(const PoseGraphEdge& edge) const {
  const Eigen::Vector3d error = edge_error(edge, poses_[static_cast<std::size_t>(edge.from)],
                                           poses_[static_cast<std::size_t>(edge.to)]);
  return error.dot(edge.information * error);
}

double PoseGraph::weighted_chi2(const std::vector<double>& weights) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < edges_.size(); ++i) sum += weights[i] * edge_chi2(edges_[i]);
  return sum;
}

double PoseGraph::chi2() const { return weighted_chi2(std::vector<double>(edges_.size(), 1.0)); }

PoseGraphResult PoseGraph::optimize() {
  return optimize_weighted(std::vector<double>(edges_.size(), 1.0), options_.min_relative_decrease);
}

PoseGraphResult PoseGraph::optimize_roughly() {
  return optimize_weighted(std::vector<double>(edges_.size(), 1.0),
                           options_.rough_relative_decrease);
}

PoseGraphResult PoseGraph::optimize_robustly() { return LoopChoice(*this, options_).run(); }

void PoseGraph::fill(SparseNormalEquations& equations,
                     const std::vector<double>& weights,
                     Moves moves) const {
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const PoseGraphEdge& edge = edges_[i];
    if (weights[i] == 0.0) continue;  // or a wrong loop would fill the factorization
    add_edge_to(equations, edge, poses_, weights[i], moves);
  }
}

PoseGraphResult PoseGraph::optimize_weighted(const std::vector<double>& weights,
                                             double min_relative_decrease) {
  PoseGraphResult result;
  result.edge_is_inlier.assign(edges_.size(), true);
  if (poses_.size() < 2 || edges_.empty()) {
    result.converged = true;
    return result;
  }
  Solver solver;
  bool analyzed = false;
  constexpr double kNoDamping = 1e-12, kFirstDamping = 1e-9;  // of the diagonal
  double lambda = 0.0, growth = 2.0;
  double error = weighted_chi2(weights);
  SparseNormalEquations equations(poses_.size());
  while (result.iterations < options_.max_iterations && !result.converged) {
    ++result.iterations;
    equations.restart();
    fill(equations, weights, Moves::poses);
    SparseMatrix hessian = equations.hessian();
    // A node without edges would make the system singular; this keeps it where it is.
    const Eigen::VectorXd diagonal = hessian.diagonal();
    hessian.diagonal() = (diagonal * (1.0 + lambda)).cwiseMax(1e-9);
    if (!analyzed) solver.analyzePattern(hessian);
    analyzed = true;
    solver.factorize(hessian);
    const std::vector<Pose2> before = poses_;
    double predicted = 0.0;
    if (solver.info() == Eigen::Success) {
      const Eigen::VectorXd step = -solver.solve(equations.gradient());
      predicted = lambda * step.dot(diagonal.cwiseProduct(step)) - equations.gradient().dot(step);
      move_poses(poses_, step);
    }
    double new_error = weighted_chi2(weights);
    const double part = (error - new_error) / predicted;
    if (predicted > options_.min_relative_decrease * error && std::abs(part - 1.0) > kAsPredicted) {
      new_error = settle_translations(weights, new_error);
    }
    if (solver.info() == Eigen::Success && std::isfinite(new_error) && new_error <= error) {
      result.converged = error - new_error <= min_relative_decrease * error + kNoError;
      // Nielsen's rule (1999): a weak mode of a long chain wants a damping that is not forgotten.
      const double gain = predicted > 0.0 ? (error - new_error) / predicted : 1.0;
      error = new_error;
      lambda *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3));
      if (lambda < kNoDamping) lambda = 0.0;
      growth = 2.0;
    } else {
      poses_ = before;
      result.converged = lambda > 1e6;  // no step helps any more
      lambda = std::max(lambda * growth, kFirstDamping);
      growth *= 2.0;
    }
  }
  result.chi2 = error;
  return result;
}

double PoseGraph::settle_translations(const std::vector<double>& weights, double error) {
  SparseNormalEquations equations(poses_.size());
  fill(equations, weights, Moves::translations);
  SparseMatrix hessian = equations.hessian();
  hessian.diagonal() = hessian.diagonal().cwiseMax(1e-9).eval();
  const Solver solver(hessian);
  if (solver.info() != Eigen::Success) return error;
  const std::vector<Pose2> before = poses_;
  move_poses(poses_, -solver.solve(equations.gradient()));
  const double settled = weighted_chi2(weights);
  if (settled < error) return settled;
  poses_ = before;
  return error;
}

}  // namespace marco::slam
