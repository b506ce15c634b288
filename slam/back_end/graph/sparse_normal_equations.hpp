#pragma once

#include <Eigen/SparseCore>
#include <unordered_map>
#include <vector>

#include "common/pose2.hpp"

namespace marco::slam {

/// Normal equations of poses on the floor, 3x3 block by block; node 0 is held fixed and left out.
/// Increments are (dx, dy, dtheta) in the world frame. Not thread-safe.
class SparseNormalEquations {
 public:
  explicit SparseNormalEquations(std::size_t nodes);

  /// All sums are 0 again; which pairs of nodes meet is remembered.
  void restart();

  /// Adds to block (row, column); of the two blocks of a pair either may be given.
  void add_block(int row_node, int column_node, const Eigen::Matrix3d& block);
  void add_gradient(int node, const Eigen::Vector3d& part);

  /// The solution x of hessian * x = gradient by conjugate gradients: for systems as dense as a
  /// place seen many times, where a factorization fills up. Preconditioned by the block tridiagonal
  /// part, the blocks of consecutive scans: it is positive since each constraint is.
  /// @param damping  added to the diagonal, as a part of it
  /// @param tolerance  of the residual, as a part of the gradient's length
  Eigen::VectorXd solve_iteratively(double damping, double tolerance, int max_iterations) const;

  const Eigen::VectorXd& gradient() const { return gradient_; }
  /// The lower triangle.
  Eigen::SparseMatrix<double> hessian() const;

 private:
  struct Below {
    uint32_t column;
    uint32_t row;
    std::size_t block;
  };
  /// Pairs by column, then row.
  std::vector<Below> sorted_pairs() const;

  Eigen::VectorXd gradient_;
  std::vector<Eigen::Matrix3d> diagonal_;
  std::unordered_map<uint64_t, std::size_t> pairs_;  ///< (row, column) to its place in below_
  std::vector<Eigen::Matrix3d> below_;
};

/// Adds a step of the normal equations' solution to all poses but the first.
void move_poses(std::vector<Pose2>& poses, const Eigen::VectorXd& step);

}  // namespace marco::slam
