#include "slam/ekf/compressed_state.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace marco::slam {
namespace {

using Eigen::Index;

// Upper triangle <- lower one, in squares that fit the cache: column by column it would cost more
// than the corrections themselves.
void mirror_lower(Eigen::MatrixXd& p, Index size) {
  constexpr Index kSide = 32;
  for (Index column = 0; column < size; column += kSide) {
    const Index columns = std::min(kSide, size - column);
    p.block(column, column, columns, columns).triangularView<Eigen::StrictlyUpper>() =
        p.block(column, column, columns, columns).transpose().eval();
    for (Index row = column + kSide; row < size; row += kSide) {
      const Index rows = std::min(kSide, size - row);
      p.block(column, row, columns, rows) = p.block(row, column, rows, columns).transpose();
    }
  }
}

}  // namespace

CompressedState::CompressedState(const Eigen::Vector3d& robot, const Eigen::Matrix3d& covariance) {
  take_block();
  mean_.head<3>() = robot;
  first_.head<3>() = robot;
  active_.push_back(0);
  local_[0] = 0;
  num_walls_ = 0;
  reserve_local(4);
  p_.topLeftCorner<3, 3>() = covariance;
}

Eigen::Matrix4d CompressedState::covariance(int block_a, int block_b) const {
  return p_.block<4, 4>(at(block_a), at(block_b));
}

void CompressedState::predict(const Eigen::Vector3d& robot,
                              const Eigen::Matrix3d& jacobian,
                              const Eigen::Matrix3d& noise) {
  const Index n = local_size();
  mean_.head<3>() = robot;
  first_.head<3>() = robot;
  const Eigen::MatrixXd columns = p_.block(0, 0, n, 3) * jacobian.transpose();
  const Eigen::Matrix3d own = jacobian * columns.topRows<3>() + noise;
  p_.block(0, 0, n, 3) = columns;
  p_.block(0, 0, 3, n) = columns.transpose();
  p_.topLeftCorner<3, 3>() = 0.5 * (own + own.transpose());
  if (has_passive_) {
    const Eigen::MatrixXd phi = phi_t_.leftCols<3>() * jacobian.transpose();
    phi_t_.leftCols<3>() = phi;
  }
}

Eigen::MatrixXd CompressedState::covariance_with(const SparseRows& rows) const {
  const Index n = local_size();
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(n, rows.rows());
  for (int k = 0; k < rows.num_blocks; ++k) {
    product.noalias() += p_.block(0, at(rows.blocks[static_cast<std::size_t>(k)]), n, 4) *
                         rows.jacobian.middleCols(4 * k, 4).transpose();
  }
  return product;
}

SparseRows::Square CompressedState::covariance_between(const SparseRows& a,
                                                       const SparseRows& b) const {
  SparseRows::Square product = SparseRows::Square::Zero(a.rows(), b.rows());
  for (int i = 0; i < a.num_blocks; ++i) {
    for (int j = 0; j < b.num_blocks; ++j) {
      product.noalias() += a.jacobian.middleCols(4 * i, 4) *
                           p_.block<4, 4>(at(a.blocks[static_cast<std::size_t>(i)]),
                                          at(b.blocks[static_cast<std::size_t>(j)])) *
                           b.jacobian.middleCols(4 * j, 4).transpose();
    }
  }
  return product;
}

SparseRows::Square CompressedState::innovation_covariance(const SparseRows& rows) const {
  const SparseRows::Square s = covariance_between(rows, rows) + rows.noise;
  return 0.5 * (s + s.transpose());
}

void CompressedState::correct(const SparseRows& rows) {
  const Index n = local_size(), m = rows.rows();
  if (u_.cols() < num_u_ + m) u_.conservativeResize(u_.rows(), 2 * (num_u_ + m));
  Eigen::MatrixXd product = covariance_with(rows);
  // H U of the corrections before, which P does not hold yet.
  Eigen::Matrix<double, SparseRows::kMaxRows, Eigen::Dynamic> h_u(SparseRows::kMaxRows, num_u_);
  h_u.setZero();
  for (int k = 0; k < rows.num_blocks; ++k) {
    h_u.topRows(m).noalias() +=
        rows.jacobian.middleCols(4 * k, 4) *
        u_.block(at(rows.blocks[static_cast<std::size_t>(k)]), 0, 4, num_u_);
  }
  product.noalias() -= u_.topLeftCorner(n, num_u_) * h_u.topRows(m).transpose();
  SparseRows::Square s = rows.noise;  // (5.36)
  for (int k = 0; k < rows.num_blocks; ++k) {
    s.noalias() += rows.jacobian.middleCols(4 * k, 4) *
                   product.middleRows(at(rows.blocks[static_cast<std::size_t>(k)]), 4);
  }
  const Eigen::LLT<SparseRows::Square> factor(0.5 * (s + s.transpose()));
  const SparseRows::Vector y = factor.matrixL().solve(rows.innovation);
  auto u = u_.block(0, num_u_, n, m);
  u = factor.matrixL().solve(product.transpose()).transpose();
  const Eigen::VectorXd change = u * y;  // K nu, (5.34)
  for (std::size_t k = 0; k < active_.size(); ++k) {
    mean_.segment<4>(4 * active_[k]) += change.segment<4>(4 * static_cast<Index>(k));
  }
  if (has_passive_) {
    if (weights_t_.cols() < num_weights_ + m) {
      weights_t_.conservativeResize(weights_t_.rows(), 2 * (num_weights_ + m));
    }
    Eigen::MatrixXd w_t =
        -(weights_t_.middleCols(first_new_weight_, num_u_) * h_u.topRows(m).transpose());
    for (int k = 0; k < rows.num_blocks; ++k) {
      w_t.noalias() += phi_t_.middleCols(at(rows.blocks[static_cast<std::size_t>(k)]), 4) *
                       rows.jacobian.middleCols(4 * k, 4).transpose();
    }
    weights_t_.middleCols(num_weights_, m) = factor.matrixL().solve(w_t.transpose()).transpose();
    theta_.noalias() += weights_t_.middleCols(num_weights_, m) * y;
    num_weights_ += m;
  }
  num_u_ += m;
}

void CompressedState::finish_corrections() {
  if (num_u_ == 0) return;
  const Index n = local_size();
  auto p = p_.topLeftCorner(n, n);
  const auto u = u_.topLeftCorner(n, num_u_);
  p.selfadjointView<Eigen::Lower>().rankUpdate(u, -1.0);
  mirror_lower(p_, n);
  if (has_passive_) {
    phi_t_.leftCols(n).noalias() -=
        weights_t_.middleCols(first_new_weight_, num_u_) * u.transpose();
    if (num_weights_ > kMaxWeights) {
      psi_.selfadjointView<Eigen::Lower>().rankUpdate(weights_t_.leftCols(num_weights_));
      has_psi_ = true;
      num_weights_ = 0;
    }
    first_new_weight_ = num_weights_;
  }
  num_u_ = 0;
}

}  // namespace marco::slam
