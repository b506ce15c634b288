#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "slam/line_slam/ekf/add_product.hpp"
#include "slam/line_slam/ekf/sparse_rows.hpp"
#include "slam/line_slam/ekf/tiled_covariance.hpp"

namespace marco::slam {

/// Mean and covariance of robot and walls, in blocks of four numbers: block 0 is the robot (x, y,
/// theta, unused), each other one a wall (x1, y1, x2, y2), world frame [m, rad].
///
/// Compressed (Guivant and Nebot 2001): every step touches the covariance P_AA of the active blocks
/// only. What it does to the others is collected as P_AB <- Phi P_AB, P_BB -= P_BA W^T W P_AB and
/// x_B += P_BA theta, and carried out by settle(); the part of it that touches all of P_BB is
/// spread over later steps (TiledCovariance). The result is the dense filter's to rounding.
///
/// Beside each estimate stands the point where Jacobians are taken (first-estimates Jacobians,
/// Huang, Mourikis and Roumeliotis 2008). Not thread-safe.
class CompressedState {
 public:
  /// The robot alone.
  CompressedState(const Eigen::Vector3d& robot, const Eigen::Matrix3d& covariance);

  int num_blocks() const { return static_cast<int>(local_.size()); }
  bool is_active(int block) const { return local_[static_cast<std::size_t>(block)] >= 0; }
  std::span<const int> active() const { return active_; }
  int num_passive() const { return num_walls_ + 1 - static_cast<int>(active_.size()); }

  /// Up-to-date mean of any block. O(active) for a passive one.
  Eigen::Vector4d mean(int block) const;
  /// As above, a passive one as of the last settle() or refresh_means().
  Eigen::Vector4d rough_mean(int block) const { return mean_.segment<4>(4 * block); }
  Eigen::Vector4d first_estimate(int block) const { return first_.segment<4>(4 * block); }
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

  /// One wall's measurement: sequential innovation (5.34-5.36), S at most 4 x 4. The means are new
  /// at once; the covariance when finish_corrections() is called, which must be before anything
  /// but correct(). Blocks must be active.
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

  /// Drops an active wall: what is known of the rest stays as it is. Its block may be given out
  /// again.
  void remove(int block);

  /// Brings the means of passive walls up to date. O(passive * active).
  void refresh_means();

  /// Moves collected changes into the whole. Active blocks stay active.
  void settle();
  /// Does up to `max_tiles` of what settle() put off.
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
  /// So many columns of W^T are kept before their sum of squares is taken: large enough for a
  /// product of matrices to pay, small enough to stay in cache.
  static constexpr Eigen::Index kMaxWeights = 192;

  Eigen::Index local_size() const { return 4 * static_cast<Eigen::Index>(active_.size()); }
  Eigen::Index at(int block) const { return 4 * local_[static_cast<std::size_t>(block)]; }
  void load(std::span<const int> blocks);
  void store();
  void reserve_local(Eigen::Index size);
  Eigen::MatrixXd taken_from_passive() const;
  void drop_local(int place);
  int take_block();
  void add_times_rows(const ConstMatrixPart& columns,
                      const SparseRows& rows,
                      Eigen::MatrixXd& product) const;

  Eigen::VectorXd mean_;  ///< 4 a block; passive ones as of the last settle()
  Eigen::VectorXd first_;
  std::vector<int> local_;  ///< per block: place among the active ones, or -1
  std::vector<char> live_;  ///< per block
  std::vector<int> free_;   ///< blocks of removed walls
  int num_walls_ = 0;
  TiledCovariance whole_;

  std::vector<int> active_;  ///< blocks; [0] = robot
  Eigen::MatrixXd p_;        ///< P_AA in the upper left local_size() square
  Eigen::MatrixXd u_;        ///< corrections of this step, local_size() x num_u_
  Eigen::Index num_u_ = 0;

  // Kept only while there are passive blocks. A0 = active set at the last settle().
  bool has_passive_ = false;
  Eigen::MatrixXd passive_with_active_;  ///< P_BA0, a row a number of the whole state
  Eigen::MatrixXd phi_t_;                ///< Phi^T, A0 x A (and room)
  Eigen::MatrixXd weights_t_;            ///< W^T, A0 x num_weights_ (and room)
  Eigen::Index num_weights_ = 0;
  Eigen::Index first_new_weight_ = 0;  ///< those of the corrections not yet finished
  Eigen::MatrixXd psi_;                ///< lower half of the W^T W that no longer fits weights_t_
  bool has_psi_ = false;
  Eigen::VectorXd theta_;  ///< A0
};

}  // namespace marco::slam
