#include "slam/graph/pose_graph.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <optional>

#include "common/check.hpp"
#include "slam/graph/robust_start.hpp"
#include "slam/graph/sparse_normal_equations.hpp"

namespace marco::slam {
namespace {

// [chi2] far below what any measurement can tell: the error of an exact graph.
constexpr double kNoError = 1e-12;

// How much farther off than its limit a loop may be at first, before the rest has settled.
constexpr double kFirstSlack = 64.0, kStartSlack = 16.0;

using SparseMatrix = Eigen::SparseMatrix<double>;
using Solver = Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower>;

// Least squares of a sparse linear system by its normal equations.
class LinearProblem {
 public:
  LinearProblem(int unknowns, int columns)
      : right_(Eigen::MatrixXd::Zero(unknowns, columns)), unknowns_(unknowns) {}

  // One equation block a*u_i + b*u_j = c with 2x2 coefficient blocks; index -1 = known, moved to c.
  void add(int i,
           const Eigen::Matrix2d& a,
           int j,
           const Eigen::Matrix2d& b,
           const Eigen::Vector2d& c,
           double weight) {
    add_pair(i, a, i, a, weight);
    add_pair(j, b, j, b, weight);
    add_pair(std::max(i, j), i > j ? a : b, std::min(i, j), i > j ? b : a, weight);
    if (i >= 0) right_.block<2, 1>(2 * i, 0) += weight * a.transpose() * c;
    if (j >= 0) right_.block<2, 1>(2 * j, 0) += weight * b.transpose() * c;
  }

  std::optional<Eigen::VectorXd> solve() const {
    SparseMatrix matrix(unknowns_, unknowns_);
    matrix.setFromTriplets(triplets_.begin(), triplets_.end());
    const Solver solver(matrix);
    if (solver.info() != Eigen::Success) return std::nullopt;
    const Eigen::VectorXd solution = solver.solve(right_);
    if (!solution.allFinite()) return std::nullopt;
    return solution;
  }

 private:
  void add_pair(
      int row, const Eigen::Matrix2d& a, int column, const Eigen::Matrix2d& b, double weight) {
    if (row < 0 || column < 0) return;
    const Eigen::Matrix2d block = weight * a.transpose() * b;
    for (int r = 0; r < 2; ++r) {
      for (int c = 0; c < (row == column ? r + 1 : 2); ++c) {
        triplets_.emplace_back(2 * row + r, 2 * column + c, block(r, c));
      }
    }
  }
  std::vector<Eigen::Triplet<double>> triplets_;
  Eigen::MatrixXd right_;
  int unknowns_;
};

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
  require(is_finite(edge.from_from_to) && edge.information.allFinite(),
          "PoseGraph: an edge's measurement is not finite");
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

PoseGraphResult PoseGraph::optimize_globally() {
  PoseGraph other = *this;
  const PoseGraphResult here = optimize();
  other.initialize_from_edges();
  const PoseGraphResult there = other.optimize();
  if (there.chi2 >= here.chi2) return here;
  poses_ = std::move(other.poses_);
  return there;
}

PoseGraphResult PoseGraph::optimize_roughly() {
  return optimize_weighted(std::vector<double>(edges_.size(), 1.0),
                           options_.rough_relative_decrease);
}

PoseGraphResult PoseGraph::optimize_weighted(const std::vector<double>& weights,
                                             double min_relative_decrease) {
  PoseGraphResult result;
  result.edge_in_force.assign(edges_.size(), true);
  if (poses_.size() < 2 || edges_.empty()) {
    result.converged = true;
    return result;
  }
  Solver solver;
  bool analyzed = false;
  constexpr double kNoDamping = 1e-12, kFirstDamping = 1e-9;
  double lambda = 0.0, growth = 2.0;
  double error = weighted_chi2(weights);
  SparseNormalEquations equations(poses_.size());
  while (result.iterations < options_.max_iterations && !result.converged) {
    ++result.iterations;
    equations.restart();
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const PoseGraphEdge& edge = edges_[i];
      if (weights[i] == 0.0) continue;  // or a wrong loop would fill the factorization
      add_edge_to(equations, edge, poses_[static_cast<std::size_t>(edge.from)],
                  poses_[static_cast<std::size_t>(edge.to)], weights[i]);
    }
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
    const double new_error = weighted_chi2(weights);
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

PoseGraphResult PoseGraph::optimize_robustly() {
  if (poses_.size() < 2) return optimize();
  const Pose2 first = poses_.front();
  const PoseGraphResult here = optimize_trimmed(fitting_edges(kFirstSlack), kFirstSlack);
  const bool all_in_force =
      std::all_of(here.edge_in_force.begin(), here.edge_in_force.end(), [](bool in) { return in; });
  const double cost_here = truncated_chi2();
  // Every loop agrees with the rest: there is no better end.
  if (all_in_force && cost_here <= here.chi2) return here;
  const std::vector<Pose2> poses_here = poses_;
  const RobustStart start =
      robust_start(first, poses_.size(), edges_, options_.loop_rejection_chi2);
  poses_ = start.poses;
  const PoseGraphResult there = optimize_trimmed(start.weights, kStartSlack);
  if (truncated_chi2() < cost_here) return there;
  poses_ = poses_here;
  return here;
}

std::vector<double> PoseGraph::fitting_edges(double slack) const {
  std::vector<double> weights(edges_.size(), 1.0);
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const bool wrong =
        edges_[i].is_loop && edge_chi2(edges_[i]) > slack * options_.loop_rejection_chi2;
    weights[i] = wrong ? 0.0 : 1.0;
  }
  return weights;
}

double PoseGraph::truncated_chi2() const {
  double sum = 0.0;
  for (const PoseGraphEdge& edge : edges_) {
    const double chi2 = edge_chi2(edge);
    sum += edge.is_loop ? std::min(chi2, options_.loop_rejection_chi2) : chi2;
  }
  return sum;
}

PoseGraphResult PoseGraph::optimize_trimmed(std::vector<double> weights, double slack) {
  // Loops that were left out may turn out to fit, and the other way round, once the rest agrees.
  constexpr int kMaxRounds = 10;
  constexpr double kShrink = 0.25;
  PoseGraphResult result;
  for (int round = 0; round < kMaxRounds; ++round) {
    result = optimize_weighted(
        weights, slack > 1.0 ? options_.rough_relative_decrease : options_.min_relative_decrease);
    const std::vector<double> before = weights;
    weights = fitting_edges(slack);
    if (slack <= 1.0 && weights == before) break;
    slack = std::max(1.0, slack * kShrink);
  }
  for (std::size_t i = 0; i < edges_.size(); ++i) result.edge_in_force[i] = weights[i] > 0.0;
  return result;
}

void PoseGraph::initialize_from_edges() {
  if (poses_.size() < 2) return;
  const int unknowns = 2 * (static_cast<int>(poses_.size()) - 1);
  // Rotations: (cos_j, sin_j) = R(theta_z) (cos_i, sin_i), relaxed to any two numbers.
  const Eigen::Vector2d first(std::cos(poses_[0].theta_rad), std::sin(poses_[0].theta_rad));
  LinearProblem rotations(unknowns, 1);
  for (const PoseGraphEdge& edge : edges_) {
    const Eigen::Matrix2d turn = edge.from_from_to.rotation();
    const Eigen::Vector2d known =
        edge.from == 0 ? Eigen::Vector2d(turn * first)
                       : (edge.to == 0 ? Eigen::Vector2d(-first) : Eigen::Vector2d::Zero());
    rotations.add(edge.from - 1, -turn, edge.to - 1, Eigen::Matrix2d::Identity(), known,
                  edge.information(2, 2));
  }
  const std::optional<Eigen::VectorXd> headings = rotations.solve();
  if (!headings) return;
  std::vector<Pose2> poses = poses_;
  for (std::size_t node = 1; node < poses.size(); ++node) {
    const auto at = 2 * (static_cast<Eigen::Index>(node) - 1);
    poses[node].theta_rad = std::atan2((*headings)(at + 1), (*headings)(at));
  }
  LinearProblem translations(unknowns, 1);
  for (const PoseGraphEdge& edge : edges_) {
    const Pose2& from = poses[static_cast<std::size_t>(edge.from)];
    Eigen::Vector2d step = from.rotation() * edge.from_from_to.translation_m();
    if (edge.from == 0) step += poses[0].translation_m();
    if (edge.to == 0) step -= poses[0].translation_m();
    translations.add(edge.from - 1, -Eigen::Matrix2d::Identity(), edge.to - 1,
                     Eigen::Matrix2d::Identity(), step,
                     0.5 * (edge.information(0, 0) + edge.information(1, 1)));
  }
  const std::optional<Eigen::VectorXd> positions = translations.solve();
  if (!positions) return;
  for (std::size_t node = 1; node < poses.size(); ++node) {
    const auto at = 2 * (static_cast<Eigen::Index>(node) - 1);
    poses[node].x_m = (*positions)(at);
    poses[node].y_m = (*positions)(at + 1);
  }
  poses_ = poses;
}

}  // namespace marco::slam
