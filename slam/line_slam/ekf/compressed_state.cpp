#include "slam/line_slam/ekf/compressed_state.hpp"

#include <algorithm>
#include <vector>

#include "lcm_tools/base/check.hpp"

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
  add_block();
  mean_.head<3>() = robot;
  first_.head<3>() = robot;
  reserve(4);
  p_.topLeftCorner<3, 3>() = covariance;
}

// Room in the whole for the block that was taken last.
void CompressedState::add_block() {
  if (mean_.size() == kBlockSize * blocks_.size()) return;
  mean_.conservativeResize(kBlockSize * blocks_.size());
  first_.conservativeResize(kBlockSize * blocks_.size());
  mean_.tail<4>().setZero();
  first_.tail<4>().setZero();
  whole_.grow_to(blocks_.size());
}

void CompressedState::reserve(Index rows) {
  const Index old = p_.rows();
  if (old >= rows) return;
  const Index room = std::max<Index>(2 * old, std::max<Index>(rows, 64));
  p_.conservativeResize(room, room);
  p_.rightCols(room - old).setZero();
  p_.bottomRows(room - old).setZero();
  u_.conservativeResize(room, std::max<Index>(u_.cols(), 64));
  if (deferred_.in_use()) deferred_.reserve(room);
}

Eigen::Vector4d CompressedState::mean(int block) const {
  Eigen::Vector4d value = mean_.segment<4>(kBlockSize * block);
  if (deferred_.in_use() && !is_active(block)) deferred_.add_mean_change(block, value);
  return value;
}

Eigen::Matrix4d CompressedState::covariance(int block_a, int block_b) const {
  return p_.block<4, 4>(blocks_.row_of(block_a), blocks_.row_of(block_b));
}

void CompressedState::predict(const Eigen::Vector3d& robot,
                              const Eigen::Matrix3d& jacobian,
                              const Eigen::Matrix3d& noise) {
  const Index n = blocks_.active_rows();
  mean_.head<3>() = robot;
  first_.head<3>() = robot;
  const Eigen::MatrixXd columns = p_.block(0, 0, n, 3) * jacobian.transpose();
  const Eigen::Matrix3d own = jacobian * columns.topRows<3>() + noise;
  p_.block(0, 0, n, 3) = columns;
  p_.block(0, 0, 3, n) = columns.transpose();
  p_.topLeftCorner<3, 3>() = 0.5 * (own + own.transpose());
  if (deferred_.in_use()) deferred_.predict(jacobian);
}

Eigen::MatrixXd CompressedState::covariance_with(const SparseRows& rows) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(blocks_.active_rows(), rows.rows());
  blocks_.add_times_rows(p_.topRows(blocks_.active_rows()), rows, product);
  return product;
}

SparseRows::Square CompressedState::covariance_between(const SparseRows& a,
                                                       const SparseRows& b) const {
  SparseRows::Square product = SparseRows::Square::Zero(a.rows(), b.rows());
  for (int i = 0; i < a.num_blocks; ++i) {
    for (int j = 0; j < b.num_blocks; ++j) {
      product.noalias() += a.jacobian.middleCols(kBlockSize * i, 4) *
                           p_.block<4, 4>(blocks_.row_of(a.blocks[static_cast<std::size_t>(i)]),
                                          blocks_.row_of(b.blocks[static_cast<std::size_t>(j)])) *
                           b.jacobian.middleCols(kBlockSize * j, 4).transpose();
    }
  }
  return product;
}

SparseRows::Square CompressedState::innovation_covariance(const SparseRows& rows) const {
  const SparseRows::Square s = covariance_between(rows, rows) + rows.noise;
  return 0.5 * (s + s.transpose());
}

void CompressedState::correct(const SparseRows& rows) {
  const Index n = blocks_.active_rows(), m = rows.rows();
  if (u_.cols() < num_u_ + m) u_.conservativeResize(u_.rows(), 2 * (num_u_ + m));
  Eigen::MatrixXd product = covariance_with(rows);
  // H U of the corrections before, which P does not hold yet.
  Eigen::MatrixXd h_u = Eigen::MatrixXd::Zero(m, num_u_);
  for (int k = 0; k < rows.num_blocks; ++k) {
    const Index from = blocks_.row_of(rows.blocks[static_cast<std::size_t>(k)]);
    h_u += rows.jacobian.middleCols(kBlockSize * k, 4).lazyProduct(u_.block(from, 0, 4, num_u_));
  }
  add_product(-1.0, u_.topLeftCorner(n, num_u_), h_u, product);
  SparseRows::Square s = rows.noise;  // (5.36)
  for (int k = 0; k < rows.num_blocks; ++k) {
    s += rows.jacobian.middleCols(kBlockSize * k, 4)
             .lazyProduct(
                 product.middleRows(blocks_.row_of(rows.blocks[static_cast<std::size_t>(k)]), 4));
  }
  const SparseRows::Square root = inverse_root(s);
  const SparseRows::Vector y = root.lazyProduct(rows.innovation);
  auto u = u_.block(0, num_u_, n, m);
  u.setZero();
  add_product(1.0, product, root, u);
  const Eigen::VectorXd change = u.lazyProduct(y);  // K nu, (5.34)
  for (const int block : active()) {
    mean_.segment<4>(kBlockSize * block) += change.segment<4>(blocks_.row_of(block));
  }
  if (deferred_.in_use()) deferred_.correct(rows, blocks_, h_u, root, y);
  num_u_ += m;
}

void CompressedState::finish_corrections() {
  if (num_u_ == 0) return;
  const Index n = blocks_.active_rows();
  auto p = p_.topLeftCorner(n, n);
  const auto u = u_.topLeftCorner(n, num_u_);
  add_square_to_lower(-1.0, u, p);
  mirror_lower(p_, n);
  if (deferred_.in_use()) deferred_.finish_corrections(u);
  num_u_ = 0;
}

int CompressedState::append(const Eigen::Vector4d& mean,
                            const Eigen::Vector4d& first_estimate,
                            const Eigen::Matrix<double, 4, 3>& jacobian_robot,
                            const Eigen::Matrix4d& noise) {
  const Index n = blocks_.active_rows();
  const int block = blocks_.take();
  add_block();
  reserve(n + 4);
  mean_.segment<4>(kBlockSize * block) = mean;
  first_.segment<4>(kBlockSize * block) = first_estimate;
  const Eigen::MatrixXd column = p_.block(0, 0, n, 3) * jacobian_robot.transpose();
  const Eigen::Matrix4d own = jacobian_robot * column.topRows<3>() + noise;
  p_.block(0, n, n, 4) = column;
  p_.block(n, 0, 4, n) = column.transpose();
  p_.block<4, 4>(n, n) = 0.5 * (own + own.transpose());
  if (deferred_.in_use()) deferred_.append(n, jacobian_robot, whole_.size());
  return block;
}

void CompressedState::replace(int block,
                              const SparseRows& change,
                              const Eigen::Vector4d& mean,
                              const Eigen::Vector4d& first_estimate) {
  const Index n = blocks_.active_rows(), to = blocks_.row_of(block);
  const Eigen::MatrixXd column = covariance_with(change);
  Eigen::Matrix4d own = change.noise;
  for (int k = 0; k < change.num_blocks; ++k) {
    own += change.jacobian.middleCols(kBlockSize * k, 4) *
           column.middleRows<4>(blocks_.row_of(change.blocks[static_cast<std::size_t>(k)]));
  }
  if (deferred_.in_use()) deferred_.replace(to, change, blocks_);
  p_.block(0, to, n, 4) = column;
  p_.block(to, 0, 4, n) = column.transpose();
  p_.block<4, 4>(to, to) = 0.5 * (own + own.transpose());
  mean_.segment<4>(kBlockSize * block) = mean;
  first_.segment<4>(kBlockSize * block) = first_estimate;
}

void CompressedState::remove(int block) {
  require(block > 0 && is_active(block), "compressed_state: only an active wall can be removed");
  const Index n = blocks_.active_rows(), hole = blocks_.row_of(block), last = n - 4;
  if (hole != last) {
    p_.block(0, hole, n, 4) = p_.block(0, last, n, 4).eval();
    p_.block(hole, 0, 4, n) = p_.block(last, 0, 4, n).eval();
  }
  blocks_.free(block);
  if (deferred_.in_use()) deferred_.remove(block, hole, last);
}

Eigen::Matrix4d CompressedState::marginal(int block) {
  if (is_active(block)) return covariance(block, block);
  Eigen::Matrix4d value = whole_.read(block, block);
  deferred_.correct_marginal(block, value);
  return value;
}

void CompressedState::store() {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(whole_.size(), blocks_.active_rows());
  if (deferred_.in_use()) {
    deferred_.add_columns(columns);
    refresh_means();
    const Eigen::MatrixXd factor = deferred_.outer_factor();
    if (factor.cols() > 0) whole_.subtract_outer(factor);
  }
  for (const int block : active()) {
    columns.middleRows<4>(kBlockSize * block) =
        p_.block(blocks_.row_of(block), 0, 4, columns.cols());
  }
  whole_.write(active(), columns);
}

void CompressedState::refresh_means() {
  if (deferred_.in_use()) deferred_.take_mean_changes(mean_);
}

void CompressedState::load(std::span<const int> blocks) {
  blocks_.activate(blocks);
  deferred_.end();
  const Index rows = blocks_.active_rows();
  reserve(rows);
  Eigen::MatrixXd columns = deferred_.release_columns();
  whole_.read(active(), columns);
  for (const int block : active()) {
    p_.block(blocks_.row_of(block), 0, 4, rows) = columns.middleRows<4>(kBlockSize * block);
  }
  if (num_passive() > 0) deferred_.begin(std::move(columns), blocks_, p_.cols());
}

void CompressedState::activate(std::span<const int> blocks) {
  for (const int block : blocks) {
    require(block > 0 && block < num_blocks() && blocks_.is_live(block),
            "compressed_state: no such wall to activate");
  }
  store();
  load(blocks);
}

void CompressedState::settle() {
  const std::vector<int> walls(active().begin() + 1, active().end());
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
      rows.push_back(kBlockSize * walls[k] + i);
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
    mean_.segment<4>(kBlockSize * block) = mean.segment<4>(3 + kBlockSize * k);
    first_.segment<4>(kBlockSize * block) = first_estimate.segment<4>(3 + kBlockSize * k);
  }
}

}  // namespace marco::slam
