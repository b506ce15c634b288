#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "slam/line_slam/ekf/sparse_rows.hpp"

namespace marco::slam {

/// Mean and covariance of robot and walls, in blocks of four numbers: block 0 is the robot (x, y,
/// theta, unused), each other one a wall (x1, y1, x2, y2), world frame [m, rad]. The covariance is
/// one dense matrix; a step costs O(blocks^2).
///
/// Each estimate has a linearization point of its own, where Jacobians are taken (first-estimates
/// Jacobian, Huang, Mourikis and Roumeliotis 2008). Not thread-safe.
class EkfState {
 public:
  /// The robot alone.
  EkfState(const Eigen::Vector3d& robot, const Eigen::Matrix3d& covariance);

  Eigen::Vector4d mean(int block) const { return mean_.segment<4>(kBlockSize * block); }
  Eigen::Vector4d first_estimate(int block) const { return first_.segment<4>(kBlockSize * block); }
  Eigen::Matrix4d covariance(int block_a, int block_b) const;

  /// x_r <- mean, P <- F P F^T + noise; touches the robot's rows only (5.8). The mean is also the
  /// new point of linearization.
  void predict(const Eigen::Vector3d& robot,
               const Eigen::Matrix3d& jacobian,
               const Eigen::Matrix3d& noise);

  /// P H^T, all rows of the state; a column a row of `rows`.
  Eigen::MatrixXd covariance_with(const SparseRows& rows) const;

  /// S = H P H^T + noise (5.36), of finished corrections.
  SparseRows::Square innovation_covariance(const SparseRows& rows) const;
  /// H_a P H_b^T.
  SparseRows::Square covariance_between(const SparseRows& a, const SparseRows& b) const;

  /// EKF update by one wall's measurement: sequential innovation (5.34-5.36), S at most 4 x 4. The
  /// means change at once; the covariance in finish_corrections(), which must be called before
  /// anything but correct().
  void correct(const SparseRows& rows);

  /// P <- P - U U^T for all corrections since the last call, U = P H^T S^(-1/2): equal to the
  /// Joseph form (5.32) for the optimal gain, and keeps P symmetric to the last bit.
  void finish_corrections();

  /// Adds a wall whose mean is g(robot, z): P by (5.49-5.53). @returns its block.
  int append(const Eigen::Vector4d& mean,
             const Eigen::Vector4d& first_estimate,
             const Eigen::Matrix<double, 4, 3>& jacobian_robot,
             const Eigen::Matrix4d& noise);

  /// Block <- `change.jacobian` times the blocks named + noise: extending and joining.
  /// @param change  four rows; innovation not used; noise 4 x 4.
  void replace(int block,
               const SparseRows& change,
               const Eigen::Vector4d& mean,
               const Eigen::Vector4d& first_estimate);

  /// Marginalizes a wall out: the rest of the state is unchanged. Its block is given out again.
  void remove(int block);

  /// Robot and the given walls, packed: 3 + 4 n.
  Eigen::VectorXd dense_mean(std::span<const int> walls) const;
  Eigen::MatrixXd dense_covariance(std::span<const int> walls) const;

  /// Puts stored values back: the reverse of dense_*.
  void restore(std::span<const int> walls,
               const Eigen::VectorXd& mean,
               const Eigen::VectorXd& first_estimate,
               const Eigen::MatrixXd& covariance);

 private:
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, kBlockSize>;

  Eigen::Index size() const { return mean_.size(); }
  int take_block();
  Columns columns_of(int block) const;
  void set_columns(int block, const Columns& columns);

  Eigen::VectorXd mean_, first_;  ///< 4 a block
  Eigen::MatrixXd p_;  ///< P in the upper left square of size(), on and below its diagonal blocks
  Eigen::MatrixXd u_;  ///< corrections that P lacks, a column each of num_u_
  Eigen::Index num_u_ = 0;
  std::vector<int> free_;  ///< blocks of removed walls, of any values
};

}  // namespace marco::slam
