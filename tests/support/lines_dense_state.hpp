#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/line_slam/ekf/sparse_rows.hpp"
#include "tests/support/slow_matrices.hpp"

namespace marco::testing {

/// The textbook filter: full matrices, the Joseph form, one inverse a measurement. The slow twin of
/// slam::EkfState, with the same numbers for its blocks; a removed wall's rows are dropped
/// by leaving its block out.
class LinesDenseState {
 public:
  LinesDenseState(const Eigen::Vector3d& robot, const Eigen::Matrix3d& covariance) {
    mean_ = robot;
    p_ = covariance;
    place_.assign(1, 0);
  }

  int place(int block) const { return place_[static_cast<std::size_t>(block)]; }
  const Eigen::VectorXd& mean() const { return mean_; }
  const Eigen::MatrixXd& covariance() const { return p_; }
  Eigen::Vector4d wall_mean(int block) const { return mean_.segment<4>(place(block)); }

  void predict(const Eigen::Vector3d& robot,
               const Eigen::Matrix3d& f,
               const Eigen::Matrix3d& noise) {
    Eigen::MatrixXd full = Eigen::MatrixXd::Identity(p_.rows(), p_.rows());
    full.topLeftCorner<3, 3>() = f;
    p_ = times(times(full, p_), full.transpose());
    p_.topLeftCorner<3, 3>() += noise;
    mean_.head<3>() = robot;
  }

  Eigen::MatrixXd full_rows(const slam::SparseRows& rows) const {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(rows.rows(), p_.rows());
    for (int k = 0; k < rows.num_blocks; ++k) {
      const int block = rows.blocks[static_cast<std::size_t>(k)];
      const Eigen::Index width = block == 0 ? 3 : 4;
      h.middleCols(place(block), width) += rows.jacobian.middleCols(4 * k, width);
    }
    return h;
  }

  /// (5.21), (5.26), (5.32).
  void correct(const slam::SparseRows& rows) {
    const Eigen::MatrixXd h = full_rows(rows), p_ht = times(p_, h.transpose());
    const Eigen::MatrixXd s = times(h, p_ht) + rows.noise;
    const Eigen::MatrixXd gain = times(p_ht, inverse(s));
    mean_ += gain.lazyProduct(rows.innovation);
    const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(p_.rows(), p_.rows()) - times(gain, h);
    p_ =
        times(times(rest, p_), rest.transpose()) + times(times(gain, rows.noise), gain.transpose());
  }

  void append(int block,
              const Eigen::Vector4d& mean,
              const Eigen::Matrix<double, 4, 3>& by_robot,
              const Eigen::Matrix4d& noise) {
    const Eigen::Index n = p_.rows();
    Eigen::MatrixXd grow = Eigen::MatrixXd::Zero(n + 4, n);  // G of (5.48)
    grow.topRows(n).setIdentity();
    grow.block<4, 3>(n, 0) = by_robot;
    p_ = times(times(grow, p_), grow.transpose());
    p_.bottomRightCorner<4, 4>() += noise;
    mean_.conservativeResize(n + 4);
    mean_.tail<4>() = mean;
    if (static_cast<int>(place_.size()) <= block)
      place_.resize(static_cast<std::size_t>(block) + 1);
    place_[static_cast<std::size_t>(block)] = static_cast<int>(n);
  }

  void replace(int block, const slam::SparseRows& change, const Eigen::Vector4d& mean) {
    Eigen::MatrixXd map = Eigen::MatrixXd::Identity(p_.rows(), p_.rows());
    map.middleRows<4>(place(block)) = full_rows(change);
    p_ = times(times(map, p_), map.transpose());
    p_.block<4, 4>(place(block), place(block)) += change.noise;
    mean_.segment<4>(place(block)) = mean;
  }

  void remove(int block) {
    const int gone = place(block);
    std::vector<Eigen::Index> keep;
    for (Eigen::Index i = 0; i < p_.rows(); ++i) {
      if (i < gone || i >= gone + 4) keep.push_back(i);
    }
    p_ = Eigen::MatrixXd(p_(keep, keep));
    mean_ = Eigen::VectorXd(mean_(keep));
    for (int& place : place_) {
      if (place > gone) place -= 4;
    }
  }

 private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd p_;
  std::vector<int> place_;
};

}  // namespace marco::testing
