#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "slam/line_slam/ekf/deferred_updates.hpp"
#include "slam/line_slam/ekf/sparse_rows.hpp"
#include "slam/line_slam/ekf/state_blocks.hpp"
#include "slam/line_slam/ekf/tiled_covariance.hpp"

namespace marco::slam {

/// Mean and covariance of robot and walls, in blocks of four numbers: block 0 is the robot (x, y,
/// theta, unused), each other one a wall (x1, y1, x2, y2), world frame [m, rad].
///
/// Compressed EKF (Guivant and Nebot 2001): every step touches only the covariance P_AA of the
/// active blocks. Its effect on the passive ones is collected (DeferredUpdates) and carried out by
/// settle(); the part that touches all of P_BB is spread over later steps (TiledCovariance). The
/// result equals the dense filter's up to rounding.
///
/// Each estimate has a linearization point beside it, where Jacobians are taken (first-estimates
/// Jacobian, Huang, Mourikis and Roumeliotis 2008). Not thread-safe.
class CompressedState {
 public:
  /// The robot alone.
  CompressedState(const Eigen::Vector3d& robot, const Eigen::Matrix3d& covariance);

  int num_blocks() const { return blocks_.size(); }
  bool is_active(int block) const { return blocks_.is_active(block); }
  std::span<const int> active() const { return blocks_.active(); }
  int num_passive() const { return blocks_.num_passive(); }

  /// Up-to-date mean of any block. O(active) for a passive one.
  Eigen::Vector4d mean(int block) const;
  /// As above, a passive one as of the last settle() or refresh_means().
  Eigen::Vector4d rough_mean(int block) const { return mean_.segment<4>(kBlockSize * block); }
  Eigen::Vector4d first_estimate(int block) const { return first_.segment<4>(kBlockSize * block); }
  /// Of two active blocks.
  Eigen::Matrix4d covariance(int block_a, int block_b) const;

  /// Of any one block.
  Eigen::Matrix4d marginal(int block);

  /// Makes exactly the robot and these walls active. @param blocks live, without 0 and repetitions.
  void activate(std::span<const int> blocks);

  /// x_r <- mean, P <- F P F^T + noise; touches the robot's rows only (5.8). The mean is also the
  /// new point of linearization.
  void predict(const Eigen::Vector3d& robot,
               const Eigen::Matrix3d& jacobian,
               const Eigen::Matrix3d& noise);

  /// P H^T of active blocks, all active rows; a column a row of `rows`.
  Eigen::MatrixXd covariance_with(const SparseRows& rows) const;

  /// S = H P H^T + noise (5.36), of finished corrections.
  SparseRows::Square innovation_covariance(const SparseRows& rows) const;
  /// H_a P H_b^T.
  SparseRows::Square covariance_between(const SparseRows& a, const SparseRows& b) const;

  /// EKF update by one wall's measurement: sequential innovation (5.34-5.36), S at most 4 x 4. The
  /// means change at once; the covariance in finish_corrections(), which must be called before
  /// anything but correct(). Blocks must be active.
  void correct(const SparseRows& rows);

  /// P <- P - U U^T for all corrections since the last call, U = P H^T S^(-1/2): equal to the
  /// Joseph form (5.32) for the optimal gain, and keeps P symmetric to the last bit.
  void finish_corrections();

  /// Adds a wall whose mean is g(robot, z): P by (5.49-5.53). @returns its block; it is active.
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

  /// Marginalizes an active wall out: the rest of the state is unchanged. Its block may be reused.
  void remove(int block);

  /// Brings the means of passive walls up to date. O(passive * active).
  void refresh_means();

  /// Applies the deferred changes to the whole. Active blocks stay active.
  void settle();
  /// Updates up to `max_tiles` tiles that settle() deferred.
  void catch_up(int max_tiles) { whole_.catch_up(max_tiles); }
  int pending() const { return whole_.pending(); }
  int num_tiles() const { return whole_.num_tiles(); }

  /// Robot and the given walls, packed: 3 + 4 n. Settles; O(n^2).
  Eigen::VectorXd dense_mean(std::span<const int> walls) const;
  Eigen::MatrixXd dense_covariance(std::span<const int> walls);

  /// Puts stored values back: the reverse of dense_*. All given walls must be live.
  void restore(std::span<const int> walls,
               const Eigen::VectorXd& mean,
               const Eigen::VectorXd& first_estimate,
               const Eigen::MatrixXd& covariance);

 private:
  void add_block();
  void load(std::span<const int> blocks);
  void store();
  void reserve(Eigen::Index rows);

  StateBlocks blocks_;
  Eigen::VectorXd mean_;  ///< 4 a block; passive ones as of the last settle()
  Eigen::VectorXd first_;
  TiledCovariance whole_;
  Eigen::MatrixXd p_;  ///< P_AA in the upper left square of blocks_.active_rows()
  Eigen::MatrixXd u_;  ///< corrections of this step, a column each of num_u_
  Eigen::Index num_u_ = 0;
  DeferredUpdates deferred_;
};

}  // namespace marco::slam
