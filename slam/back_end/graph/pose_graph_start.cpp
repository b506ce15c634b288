// Poses of a graph computed from its edges alone: linear problems.
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <optional>

#include "slam/back_end/graph/pose_graph.hpp"

namespace marco::slam {
namespace {

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
