#include "slam/back_end/graph/sparse_normal_equations.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

namespace marco::slam {

SparseNormalEquations::SparseNormalEquations(std::size_t nodes)
    : gradient_(Eigen::VectorXd::Zero(3 * (static_cast<Eigen::Index>(nodes) - 1))),
      diagonal_(nodes - 1, Eigen::Matrix3d::Zero()) {}

void SparseNormalEquations::add_block(int row_node, int column_node, const Eigen::Matrix3d& block) {
  if (row_node == 0 || column_node == 0) return;
  if (row_node == column_node) {
    diagonal_[static_cast<std::size_t>(row_node - 1)] += block;
    return;
  }
  const bool below = row_node > column_node;
  if (!below) std::swap(row_node, column_node);
  const uint64_t key =
      (static_cast<uint64_t>(row_node - 1) << 32U) | static_cast<uint32_t>(column_node - 1);
  const auto [entry, is_new] = pairs_.try_emplace(key, below_.size());
  if (is_new) below_.emplace_back(Eigen::Matrix3d::Zero());
  if (below) {
    below_[entry->second] += block;
  } else {
    below_[entry->second] += block.transpose();
  }
}

void SparseNormalEquations::restart() {
  gradient_.setZero();
  std::fill(diagonal_.begin(), diagonal_.end(), Eigen::Matrix3d::Zero());
  std::fill(below_.begin(), below_.end(), Eigen::Matrix3d::Zero());
}

std::vector<SparseNormalEquations::Below> SparseNormalEquations::sorted_pairs() const {
  std::vector<Below> pairs;
  pairs.reserve(pairs_.size());
  for (const auto& [key, block] : pairs_) {
    pairs.push_back(
        {static_cast<uint32_t>(key & 0xFFFFFFFFU), static_cast<uint32_t>(key >> 32U), block});
  }
  std::sort(pairs.begin(), pairs.end(), [](const Below& a, const Below& b) {
    return a.column != b.column ? a.column < b.column : a.row < b.row;
  });
  return pairs;
}

void SparseNormalEquations::add_gradient(int node, const Eigen::Vector3d& part) {
  if (node != 0) gradient_.segment<3>(3 * Eigen::Index{node - 1}) += part;
}

Eigen::SparseMatrix<double> SparseNormalEquations::hessian() const {
  const std::vector<Below> pairs = sorted_pairs();
  Eigen::SparseMatrix<double> matrix(gradient_.size(), gradient_.size());
  matrix.reserve(static_cast<Eigen::Index>(6 * diagonal_.size() + 9 * below_.size()));
  // Column by column, rows ascending: no sorting.
  std::size_t first = 0;
  for (std::size_t node = 0; node < diagonal_.size(); ++node) {
    std::size_t last = first;
    while (last < pairs.size() && pairs[last].column == node) ++last;
    const auto at = 3 * static_cast<Eigen::Index>(node);
    for (int c = 0; c < 3; ++c) {
      matrix.startVec(at + c);
      for (int r = c; r < 3; ++r) matrix.insertBack(at + r, at + c) = diagonal_[node](r, c);
      for (std::size_t pair = first; pair < last; ++pair) {
        const auto row = 3 * static_cast<Eigen::Index>(pairs[pair].row);
        const Eigen::Matrix3d& block = below_[pairs[pair].block];
        for (int r = 0; r < 3; ++r) matrix.insertBack(row + r, at + c) = block(r, c);
      }
    }
    first = last;
  }
  matrix.finalize();
  return matrix;
}

namespace {

// Cholesky of a symmetric block tridiagonal matrix, 3x3 blocks: O(blocks).
class TridiagonalSolver {
 public:
  TridiagonalSolver(const std::vector<Eigen::Matrix3d>& diagonal,
                    std::vector<Eigen::Matrix3d> below)
      : below_(std::move(below)), inverse_(diagonal.size()) {
    for (std::size_t i = 0; i < diagonal.size(); ++i) {
      Eigen::Matrix3d pivot = diagonal[i];
      if (i > 0) pivot -= below_[i] * inverse_[i - 1] * below_[i].transpose();
      inverse_[i] = pivot.inverse();
    }
  }
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const {
    Eigen::VectorXd x = right;
    const auto at = [](std::size_t i) { return 3 * static_cast<Eigen::Index>(i); };
    for (std::size_t i = 1; i < inverse_.size(); ++i) {
      const Eigen::Vector3d before = inverse_[i - 1] * x.segment<3>(at(i - 1));
      x.segment<3>(at(i)) -= below_[i] * before;
    }
    for (std::size_t i = inverse_.size(); i-- > 0;) {
      Eigen::Vector3d part = x.segment<3>(at(i));
      if (i + 1 < inverse_.size()) part -= below_[i + 1].transpose() * x.segment<3>(at(i + 1));
      x.segment<3>(at(i)) = inverse_[i] * part;
    }
    return x;
  }

 private:
  std::vector<Eigen::Matrix3d> below_;  // of row i: block (i, i - 1)
  std::vector<Eigen::Matrix3d> inverse_;
};

}  // namespace

Eigen::VectorXd SparseNormalEquations::solve_iteratively(double damping,
                                                         double tolerance,
                                                         int max_iterations) const {
  const std::vector<Below> pairs = sorted_pairs();
  std::vector<Eigen::Matrix3d> diagonal = diagonal_;
  for (Eigen::Matrix3d& block : diagonal) {
    block.diagonal() = (block.diagonal() * (1.0 + damping)).cwiseMax(1e-6);
  }
  std::vector<Eigen::Matrix3d> next_below(diagonal.size(), Eigen::Matrix3d::Zero());
  // In the order they are gone through: far more of them than the cache holds.
  std::vector<Eigen::Matrix3d> below;
  below.reserve(pairs.size());
  for (const Below& pair : pairs) {
    below.push_back(below_[pair.block]);
    if (pair.row == pair.column + 1) next_below[pair.row] = below.back();
  }
  const TridiagonalSolver tridiagonal(diagonal, std::move(next_below));
  Eigen::VectorXd x = Eigen::VectorXd::Zero(gradient_.size()), image(gradient_.size());
  Eigen::VectorXd residual = gradient_, preconditioned = tridiagonal.solve(residual);
  Eigen::VectorXd direction = preconditioned;
  double product = residual.dot(preconditioned);
  const double goal = tolerance * gradient_.norm();
  for (int i = 0; i < max_iterations && residual.norm() > goal && product > 0.0; ++i) {
    for (std::size_t node = 0; node < diagonal.size(); ++node) {
      const auto at = 3 * static_cast<Eigen::Index>(node);
      image.segment<3>(at).noalias() = diagonal[node] * direction.segment<3>(at);
    }
    for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
      const auto row = 3 * static_cast<Eigen::Index>(pairs[pair].row);
      const auto column = 3 * static_cast<Eigen::Index>(pairs[pair].column);
      const Eigen::Matrix3d& block = below[pair];
      image.segment<3>(row).noalias() += block * direction.segment<3>(column);
      image.segment<3>(column).noalias() += block.transpose() * direction.segment<3>(row);
    }
    const double step = product / direction.dot(image);
    x += step * direction;
    residual -= step * image;
    preconditioned = tridiagonal.solve(residual);
    const double next = residual.dot(preconditioned);
    direction = preconditioned + (next / product) * direction;
    product = next;
  }
  return x;
}

void move_poses(std::vector<Pose2>& poses, const Eigen::VectorXd& step) {
  for (std::size_t node = 1; node < poses.size(); ++node) {
    const Eigen::Vector3d delta = step.segment<3>(3 * (static_cast<Eigen::Index>(node) - 1));
    Pose2& pose = poses[node];
    pose = {pose.x_m + delta.x(), pose.y_m + delta.y(),
            normalize_angle(pose.theta_rad + delta.z())};
  }
}

}  // namespace marco::slam
