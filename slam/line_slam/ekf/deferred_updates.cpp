#include "slam/line_slam/ekf/deferred_updates.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace marco::slam {
namespace {

using Eigen::Index;

constexpr Index kTriangleStep = 16;  // columns of a triangle taken as full below their first

struct PivotedRoot {
  std::vector<Index> order;  // rows and columns of the matrix, largest pivot first
  Eigen::MatrixXd upper;     // rank x size: the matrix in that order is upper^T upper
};

// Cholesky factor with pivoting by the remaining diagonal. Pivots below rounding of the largest
// are rounding themselves, directions in which nothing was measured: there it ends. (Eigen's LDLT
// picks its pivots on the diagonal before elimination, and so does not reveal the rank.)
PivotedRoot pivoted_root(const Eigen::MatrixXd& psi) {
  const Index size = psi.rows();
  PivotedRoot root{std::vector<Index>(static_cast<std::size_t>(size)),
                   Eigen::MatrixXd::Zero(size, size)};
  std::iota(root.order.begin(), root.order.end(), Index{0});
  Eigen::VectorXd left = psi.diagonal();  // of the diagonal, in the present order
  const double least = 1e-16 * left.maxCoeff();
  Index rank = 0;
  for (; rank < size; ++rank) {
    Index pivot = 0;
    if (!(left.tail(size - rank).maxCoeff(&pivot) > least)) break;
    pivot += rank;
    std::swap(root.order[static_cast<std::size_t>(rank)],
              root.order[static_cast<std::size_t>(pivot)]);
    std::swap(left(rank), left(pivot));
    root.upper.col(rank).swap(root.upper.col(pivot));
    const double diagonal = std::sqrt(left(rank));
    root.upper(rank, rank) = diagonal;
    const Index row = root.order[static_cast<std::size_t>(rank)];
    for (Index j = rank + 1; j < size; ++j) {
      const double rest = psi(root.order[static_cast<std::size_t>(j)], row) -
                          root.upper.col(rank).head(rank).dot(root.upper.col(j).head(rank));
      root.upper(rank, j) = rest / diagonal;
      left(j) -= root.upper(rank, j) * root.upper(rank, j);
    }
  }
  root.upper.conservativeResize(rank, size);
  return root;
}

}  // namespace

void DeferredUpdates::begin(Eigen::MatrixXd columns, const StateBlocks& blocks, Index room) {
  in_use_ = true;
  p_ba0_ = std::move(columns);
  for (int block = 0; block < blocks.size(); ++block) {
    if (blocks.is_active(block) || !blocks.is_live(block)) {
      p_ba0_.middleRows<4>(kBlockSize * block).setZero();
    }
  }
  const Index size = blocks.active_rows();
  phi_t_.setZero(size, room);
  phi_t_.leftCols(size).setIdentity();
  weights_t_.resize(size, kMaxWeights + 64);
  num_weights_ = first_new_weight_ = 0;
  psi_.setZero(size, size);
  has_psi_ = false;
  theta_.setZero(size);
}

void DeferredUpdates::predict(const Eigen::Matrix3d& jacobian) {
  const Eigen::MatrixXd phi = phi_t_.leftCols<3>() * jacobian.transpose();
  phi_t_.leftCols<3>() = phi;
}

void DeferredUpdates::append(Index row,
                             const Eigen::Matrix<double, 4, 3>& jacobian_robot,
                             Index whole_size) {
  phi_t_.middleCols<4>(row) = phi_t_.leftCols<3>() * jacobian_robot.transpose();
  const Index rows = p_ba0_.rows();
  if (rows >= whole_size) return;
  p_ba0_.conservativeResize(whole_size, Eigen::NoChange);
  p_ba0_.bottomRows(whole_size - rows).setZero();
}

void DeferredUpdates::replace(Index row, const SparseRows& change, const StateBlocks& blocks) {
  Eigen::MatrixXd phi = Eigen::MatrixXd::Zero(phi_t_.rows(), 4);
  for (int k = 0; k < change.num_blocks; ++k) {
    phi += phi_t_.middleCols(blocks.row_of(change.blocks[static_cast<std::size_t>(k)]), 4) *
           change.jacobian.middleCols(kBlockSize * k, 4).transpose();
  }
  phi_t_.middleCols<4>(row) = phi;
}

void DeferredUpdates::remove(int block, Index hole, Index last) {
  if (hole != last) phi_t_.middleCols<4>(hole) = phi_t_.middleCols<4>(last).eval();
  p_ba0_.middleRows<4>(kBlockSize * block).setZero();
}

void DeferredUpdates::correct(const SparseRows& rows,
                              const StateBlocks& blocks,
                              const Eigen::MatrixXd& h_u,
                              const SparseRows::Square& root,
                              const SparseRows::Vector& y) {
  const Index m = rows.rows();
  if (weights_t_.cols() < num_weights_ + m) {
    weights_t_.conservativeResize(weights_t_.rows(), 2 * (num_weights_ + m));
  }
  Eigen::MatrixXd w_t = Eigen::MatrixXd::Zero(phi_t_.rows(), m);
  add_product(-1.0, weights_t_.middleCols(first_new_weight_, h_u.cols()), h_u, w_t);
  blocks.add_times_rows(phi_t_, rows, w_t);
  auto weights = weights_t_.middleCols(num_weights_, m);
  weights.setZero();
  add_product(1.0, w_t, root, weights);
  theta_ += weights.lazyProduct(y);
  num_weights_ += m;
}

void DeferredUpdates::finish_corrections(const ConstMatrixPart& u) {
  add_product(-1.0, weights_t_.middleCols(first_new_weight_, u.cols()), u,
              phi_t_.leftCols(u.rows()));
  if (num_weights_ > kMaxWeights) {
    add_square_to_lower(1.0, weights_t_.leftCols(num_weights_), psi_);
    has_psi_ = true;
    num_weights_ = 0;
  }
  first_new_weight_ = num_weights_;
}

void DeferredUpdates::add_mean_change(int block, Eigen::Vector4d& mean) const {
  mean += p_ba0_.middleRows<4>(kBlockSize * block) * theta_;
}

void DeferredUpdates::take_mean_changes(Eigen::VectorXd& means) {
  means += p_ba0_ * theta_;
  theta_.setZero();
}

void DeferredUpdates::correct_marginal(int block, Eigen::Matrix4d& covariance) const {
  const auto row = p_ba0_.middleRows<4>(kBlockSize * block);
  const Eigen::MatrixXd weighted = row.lazyProduct(weights_t_.leftCols(num_weights_));
  covariance -= weighted.lazyProduct(weighted.transpose());
  if (!has_psi_) return;
  const Eigen::MatrixXd psi = psi_.selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd with_psi = row.lazyProduct(psi);
  covariance -= with_psi.lazyProduct(row.transpose());
}

void DeferredUpdates::add_columns(Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd phi = phi_t_.leftCols(columns.cols()).transpose();
  add_product(1.0, p_ba0_, phi, columns);
}

Eigen::MatrixXd DeferredUpdates::outer_factor() const {
  if (!has_psi_) {
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(p_ba0_.rows(), num_weights_);
    const Eigen::MatrixXd weights = weights_t_.leftCols(num_weights_).transpose();
    add_product(1.0, p_ba0_, weights, factor);
    return factor;
  }
  Eigen::MatrixXd psi = psi_;
  if (num_weights_ > 0) add_square_to_lower(1.0, weights_t_.leftCols(num_weights_), psi);
  const auto [order, root] = pivoted_root(psi.selfadjointView<Eigen::Lower>());
  const Index size = psi.rows(), rank = root.rows();
  const Eigen::MatrixXd pivoted = p_ba0_(Eigen::all, order);
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(p_ba0_.rows(), rank);
  for (Index from = 0; from < rank; from += kTriangleStep) {
    const Index columns = std::min(kTriangleStep, rank - from);
    add_product(1.0, pivoted.rightCols(size - from), root.block(from, from, columns, size - from),
                factor.middleCols(from, columns));
  }
  return factor;
}

}  // namespace marco::slam
