#include "slam/graph/sparse_normal_equations.hpp"

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
  const auto [entry, is_new] = below_.try_emplace(key, Eigen::Matrix3d::Zero());
  if (below) {
    entry->second += block;
  } else {
    entry->second += block.transpose();
  }
}

void SparseNormalEquations::add_gradient(int node, const Eigen::Vector3d& part) {
  if (node != 0) gradient_.segment<3>(3 * (node - 1)) += part;
}

Eigen::SparseMatrix<double> SparseNormalEquations::hessian() const {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(6 * diagonal_.size() + 9 * below_.size());
  for (std::size_t node = 0; node < diagonal_.size(); ++node) {
    const int at = 3 * static_cast<int>(node);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) triplets.emplace_back(at + r, at + c, diagonal_[node](r, c));
    }
  }
  for (const auto& [key, block] : below_) {
    const int row = 3 * static_cast<int>(key >> 32U);
    const int column = 3 * static_cast<int>(key & 0xFFFFFFFFU);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) triplets.emplace_back(row + r, column + c, block(r, c));
    }
  }
  Eigen::SparseMatrix<double> matrix(gradient_.size(), gradient_.size());
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

Eigen::VectorXd SparseNormalEquations::solve_iteratively(double damping,
                                                         double tolerance,
                                                         int max_iterations) const {
  struct Block {
    Eigen::Index row;
    Eigen::Index column;
    Eigen::Matrix3d value;
  };
  std::vector<Block> below;
  below.reserve(below_.size());
  for (const auto& [key, value] : below_) {
    below.push_back({3 * static_cast<Eigen::Index>(key >> 32U),
                     3 * static_cast<Eigen::Index>(key & 0xFFFFFFFFU), value});
  }
  std::sort(below.begin(), below.end(), [](const Block& a, const Block& b) {
    return a.row != b.row ? a.row < b.row : a.column < b.column;
  });
  std::vector<Eigen::Matrix3d> diagonal = diagonal_, inverse(diagonal_.size());
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    diagonal[i].diagonal() = (diagonal[i].diagonal() * (1.0 + damping)).cwiseMax(1e-6);
    inverse[i] = diagonal[i].inverse();
  }
  const auto times = [](const std::vector<Eigen::Matrix3d>& blocks, const Eigen::VectorXd& x) {
    Eigen::VectorXd y(x.size());
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const auto at = 3 * static_cast<Eigen::Index>(i);
      y.segment<3>(at).noalias() = blocks[i] * x.segment<3>(at);
    }
    return y;
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(gradient_.size());
  Eigen::VectorXd residual = gradient_, preconditioned = times(inverse, residual);
  Eigen::VectorXd direction = preconditioned;
  double product = residual.dot(preconditioned);
  const double goal = tolerance * gradient_.norm();
  for (int i = 0; i < max_iterations && residual.norm() > goal && product > 0.0; ++i) {
    Eigen::VectorXd image = times(diagonal, direction);
    for (const Block& block : below) {
      image.segment<3>(block.row).noalias() += block.value * direction.segment<3>(block.column);
      image.segment<3>(block.column).noalias() +=
          block.value.transpose() * direction.segment<3>(block.row);
    }
    const double step = product / direction.dot(image);
    x += step * direction;
    residual -= step * image;
    preconditioned = times(inverse, residual);
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
