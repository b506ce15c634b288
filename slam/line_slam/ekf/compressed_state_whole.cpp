#include "slam/line_slam/ekf/compressed_state.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "lcm_tools/base/check.hpp"
#include "slam/line_slam/ekf/add_product.hpp"

namespace marco::slam {

using Eigen::Index;

namespace {

constexpr Index kTriangleStep = 16;  // columns of a triangle taken as full below their first

struct PivotedRoot {
  std::vector<Index> order;  // rows and columns of the matrix, largest pivot first
  Eigen::MatrixXd upper;     // rank x size: the matrix in that order is upper^T upper
};

// Cholesky's root by pivots in order of size. Below rounding of the largest they are rounding
// themselves, directions in which nothing was measured: there it ends.
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

Eigen::Vector4d CompressedState::mean(int block) const {
  Eigen::Vector4d value = mean_.segment<4>(4 * block);
  if (has_passive_ && !is_active(block)) {
    value += passive_with_active_.middleRows<4>(4 * block) * theta_;
  }
  return value;
}

Eigen::Matrix4d CompressedState::marginal(int block) {
  if (is_active(block)) return covariance(block, block);
  Eigen::Matrix4d value = whole_.read(block, block);
  const auto row = passive_with_active_.middleRows<4>(4 * block);
  const Eigen::MatrixXd weighted = row.lazyProduct(weights_t_.leftCols(num_weights_));
  value -= weighted.lazyProduct(weighted.transpose());
  if (has_psi_) {
    const Eigen::MatrixXd psi = psi_.selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd with_psi = row.lazyProduct(psi);
    value -= with_psi.lazyProduct(row.transpose());
  }
  return value;
}

// V with V V^T = P_BA0 (W^T W) P_A0B: what the corrections took off the passive part.
Eigen::MatrixXd CompressedState::taken_from_passive() const {
  if (!has_psi_) {
    Eigen::MatrixXd taken = Eigen::MatrixXd::Zero(whole_.size(), num_weights_);
    const Eigen::MatrixXd weights = weights_t_.leftCols(num_weights_).transpose();
    add_product(1.0, passive_with_active_, weights, taken);
    return taken;
  }
  Eigen::MatrixXd psi = psi_;
  if (num_weights_ > 0) add_square_to_lower(1.0, weights_t_.leftCols(num_weights_), psi);
  const auto [order, root] = pivoted_root(psi.selfadjointView<Eigen::Lower>());
  const Index size = psi.rows(), rank = root.rows();
  const Eigen::MatrixXd pivoted = passive_with_active_(Eigen::all, order);
  Eigen::MatrixXd taken = Eigen::MatrixXd::Zero(whole_.size(), rank);
  for (Index from = 0; from < rank; from += kTriangleStep) {
    const Index columns = std::min(kTriangleStep, rank - from);
    add_product(1.0, pivoted.rightCols(size - from), root.block(from, from, columns, size - from),
                taken.middleCols(from, columns));
  }
  return taken;
}

void CompressedState::store() {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(whole_.size(), local_size());
  if (has_passive_) {
    const Eigen::MatrixXd phi = phi_t_.leftCols(local_size()).transpose();
    add_product(1.0, passive_with_active_, phi, columns);
    refresh_means();
    const Eigen::MatrixXd taken = taken_from_passive();
    if (taken.cols() > 0) whole_.subtract_outer(taken);
  }
  for (const int block : active_) {
    columns.middleRows<4>(4 * block) = p_.block(at(block), 0, 4, local_size());
  }
  whole_.write(active_, columns);
}

void CompressedState::refresh_means() {
  if (!has_passive_) return;
  mean_ += passive_with_active_ * theta_;
  theta_.setZero();
}

void CompressedState::load(std::span<const int> blocks) {
  for (const int block : active_) local_[static_cast<std::size_t>(block)] = -1;
  active_.assign(1, 0);
  for (const int block : blocks) active_.push_back(block);
  for (std::size_t k = 0; k < active_.size(); ++k) {
    local_[static_cast<std::size_t>(active_[k])] = static_cast<int>(k);
  }
  has_passive_ = false;
  reserve_local(local_size());
  whole_.read(active_, passive_with_active_);
  for (const int block : active_) {
    p_.block(at(block), 0, 4, local_size()) = passive_with_active_.middleRows<4>(4 * block);
  }
  has_passive_ = num_passive() > 0;
  if (!has_passive_) {
    passive_with_active_.resize(0, 0);
    return;
  }
  for (int block = 0; block < num_blocks(); ++block) {
    if (is_active(block) || live_[static_cast<std::size_t>(block)] == 0) {
      passive_with_active_.middleRows<4>(4 * block).setZero();
    }
  }
  const Index size = local_size();
  phi_t_.setZero(size, p_.cols());
  phi_t_.leftCols(size).setIdentity();
  weights_t_.resize(size, kMaxWeights + 64);
  num_weights_ = 0;
  first_new_weight_ = 0;
  psi_.setZero(size, size);
  has_psi_ = false;
  theta_.setZero(size);
}

void CompressedState::activate(std::span<const int> blocks) {
  for (const int block : blocks) {
    require(block > 0 && block < num_blocks() && live_[static_cast<std::size_t>(block)] != 0,
            "compressed_state: no such wall to activate");
  }
  store();
  load(blocks);
}

void CompressedState::settle() {
  const std::vector<int> walls(active_.begin() + 1, active_.end());
  activate(walls);
}

Eigen::VectorXd CompressedState::dense_mean(std::span<const int> walls) const {
  Eigen::VectorXd packed(3 + 4 * static_cast<Index>(walls.size()));
  packed.head<3>() = mean_.head<3>();
  for (std::size_t k = 0; k < walls.size(); ++k) {
    packed.segment<4>(3 + 4 * static_cast<Index>(k)) = mean(walls[k]);
  }
  return packed;
}

Eigen::MatrixXd CompressedState::dense_covariance(std::span<const int> walls) {
  settle();
  std::vector<int> blocks(1, 0);
  blocks.insert(blocks.end(), walls.begin(), walls.end());
  Eigen::MatrixXd columns;
  whole_.read(blocks, columns);
  std::vector<Index> rows{0, 1, 2};
  std::vector<Index> places{0, 1, 2};
  for (std::size_t k = 0; k < walls.size(); ++k) {
    for (Index i = 0; i < 4; ++i) {
      rows.push_back(4 * walls[k] + i);
      places.push_back(4 * static_cast<Index>(k + 1) + i);
    }
  }
  return columns(rows, places);
}

void CompressedState::restore(std::span<const int> walls,
                              const Eigen::VectorXd& mean,
                              const Eigen::VectorXd& first_estimate,
                              const Eigen::MatrixXd& covariance) {
  activate(walls);
  const auto n = static_cast<Index>(walls.size());
  require(mean.size() == 3 + 4 * n && first_estimate.size() == mean.size() &&
              covariance.rows() == mean.size() && covariance.cols() == mean.size(),
          "compressed_state: stored sizes do not agree");
  p_.topLeftCorner(4 + 4 * n, 4 + 4 * n).setZero();
  p_.topLeftCorner<3, 3>() = covariance.topLeftCorner<3, 3>();
  p_.block(4, 0, 4 * n, 3) = covariance.bottomLeftCorner(4 * n, 3);
  p_.block(0, 4, 3, 4 * n) = covariance.topRightCorner(3, 4 * n);
  p_.block(4, 4, 4 * n, 4 * n) = covariance.bottomRightCorner(4 * n, 4 * n);
  mean_.head<3>() = mean.head<3>();
  first_.head<3>() = first_estimate.head<3>();
  for (Index k = 0; k < n; ++k) {
    const int block = walls[static_cast<std::size_t>(k)];
    mean_.segment<4>(4 * block) = mean.segment<4>(3 + 4 * k);
    first_.segment<4>(4 * block) = first_estimate.segment<4>(3 + 4 * k);
  }
}

}  // namespace marco::slam
