#pragma once

#include <Eigen/Core>

#include "slam/line_slam/ekf/sparse_rows.hpp"
#include "slam/line_slam/ekf/state_blocks.hpp"

namespace marco::slam {

/// What the steps of a compressed filter do to its passive blocks B, collected until they are
/// needed (Guivant and Nebot 2001): P_BA = P_BA0 Phi^T, P_BB -= P_BA0 (W^T W) P_A0B and
/// x_B += P_BA0 theta. A0 = the active set at begin(), A = the active set now.
class DeferredUpdates {
 public:
  /// Whether there are passive blocks. Only then may the steps below be called.
  bool in_use() const { return in_use_; }
  void end() { in_use_ = false; }

  /// A buffer for begin(): the memory of the one before.
  Eigen::MatrixXd release_columns() { return std::move(p_ba0_); }
  /// @param columns  those of the active blocks, a row per number of the whole state.
  /// @param room     columns to reserve for active rows.
  void begin(Eigen::MatrixXd columns, const StateBlocks& blocks, Eigen::Index room);
  void reserve(Eigen::Index room) { phi_t_.conservativeResize(phi_t_.rows(), room); }

  // The steps of CompressedState.
  void predict(const Eigen::Matrix3d& jacobian);
  void append(Eigen::Index row,
              const Eigen::Matrix<double, 4, 3>& jacobian_robot,
              Eigen::Index whole_size);
  void replace(Eigen::Index row, const SparseRows& change, const StateBlocks& blocks);
  /// The last active block, at row `last`, takes the place of the one at row `hole`.
  void remove(int block, Eigen::Index hole, Eigen::Index last);
  /// @param h_u   H U of the corrections since the last finish_corrections().
  /// @param root  S^(-1/2). @param y  whitened innovation.
  void correct(const SparseRows& rows,
               const StateBlocks& blocks,
               const Eigen::MatrixXd& h_u,
               const SparseRows::Square& root,
               const SparseRows::Vector& y);
  /// @param u  U of the corrections, active rows.
  void finish_corrections(const ConstMatrixPart& u);

  void add_mean_change(int block, Eigen::Vector4d& mean) const;
  /// Adds the changes of all means once.
  void take_mean_changes(Eigen::VectorXd& means);
  void correct_marginal(int block, Eigen::Matrix4d& covariance) const;
  /// columns += P_BA of now.
  void add_columns(Eigen::MatrixXd& columns) const;
  /// V with V V^T = P_BA0 (W^T W) P_A0B: what the corrections took off P_BB.
  Eigen::MatrixXd outer_factor() const;

 private:
  /// W^T is summed up to W^T W beyond this many columns: enough for a matrix product to pay, few
  /// enough to stay in cache.
  static constexpr Eigen::Index kMaxWeights = 192;

  bool in_use_ = false;
  Eigen::MatrixXd p_ba0_;      ///< a row per number of the whole state
  Eigen::MatrixXd phi_t_;      ///< Phi^T, A0 x A (and room)
  Eigen::MatrixXd weights_t_;  ///< W^T, A0 x num_weights_ (and room)
  Eigen::Index num_weights_ = 0;
  Eigen::Index first_new_weight_ = 0;  ///< of the corrections not yet finished
  Eigen::MatrixXd psi_;                ///< lower half of the W^T W that was summed up
  bool has_psi_ = false;
  Eigen::VectorXd theta_;
};

}  // namespace marco::slam
