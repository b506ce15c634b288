#include "slam/line_slam/ekf/compressed_state.hpp"

#include <algorithm>

#include "slam/line_slam/ekf/add_product.hpp"

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
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(local_size(), rows.rows());
  add_times_rows(p_.topRows(local_size()), rows, product);
  return product;
}

// product += columns H^T, of the columns that belong to the rows' blocks.
void CompressedState::add_times_rows(const ConstMatrixPart& columns,
                                     const SparseRows& rows,
                                     Eigen::MatrixXd& product) const {
  for (int k = 0; k < rows.num_blocks; ++k) {
    add_product(1.0, columns.middleCols(at(rows.blocks[static_cast<std::size_t>(k)]), 4),
                rows.jacobian.middleCols(4 * k, 4), product);
  }
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
  Eigen::MatrixXd h_u = Eigen::MatrixXd::Zero(m, num_u_);
  for (int k = 0; k < rows.num_blocks; ++k) {
    const Index from = at(rows.blocks[static_cast<std::size_t>(k)]);
    h_u += rows.jacobian.middleCols(4 * k, 4).lazyProduct(u_.block(from, 0, 4, num_u_));
  }
  add_product(-1.0, u_.topLeftCorner(n, num_u_), h_u, product);
  SparseRows::Square s = rows.noise;  // (5.36)
  for (int k = 0; k < rows.num_blocks; ++k) {
    s += rows.jacobian.middleCols(4 * k, 4).lazyProduct(
        product.middleRows(at(rows.blocks[static_cast<std::size_t>(k)]), 4));
  }
  const SparseRows::Square root = inverse_root(s);
  const SparseRows::Vector y = root.lazyProduct(rows.innovation);
  auto u = u_.block(0, num_u_, n, m);
  u.setZero();
  add_product(1.0, product, root, u);
  const Eigen::VectorXd change = u.lazyProduct(y);  // K nu, (5.34)
  for (std::size_t k = 0; k < active_.size(); ++k) {
    mean_.segment<4>(4 * active_[k]) += change.segment<4>(4 * static_cast<Index>(k));
  }
  if (has_passive_) {
    if (weights_t_.cols() < num_weights_ + m) {
      weights_t_.conservativeResize(weights_t_.rows(), 2 * (num_weights_ + m));
    }
    Eigen::MatrixXd w_t = Eigen::MatrixXd::Zero(phi_t_.rows(), m);
    add_product(-1.0, weights_t_.middleCols(first_new_weight_, num_u_), h_u, w_t);
    add_times_rows(phi_t_, rows, w_t);
    auto weights = weights_t_.middleCols(num_weights_, m);
    weights.setZero();
    add_product(1.0, w_t, root, weights);
    theta_ += weights.lazyProduct(y);
    num_weights_ += m;
  }
  num_u_ += m;
}

void CompressedState::finish_corrections() {
  if (num_u_ == 0) return;
  const Index n = local_size();
  auto p = p_.topLeftCorner(n, n);
  const auto u = u_.topLeftCorner(n, num_u_);
  add_square_to_lower(-1.0, u, p);
  mirror_lower(p_, n);
  if (has_passive_) {
    add_product(-1.0, weights_t_.middleCols(first_new_weight_, num_u_), u, phi_t_.leftCols(n));
    if (num_weights_ > kMaxWeights) {
      add_square_to_lower(1.0, weights_t_.leftCols(num_weights_), psi_);
      has_psi_ = true;
      num_weights_ = 0;
    }
    first_new_weight_ = num_weights_;
  }
  num_u_ = 0;
}

}  // namespace marco::slam
