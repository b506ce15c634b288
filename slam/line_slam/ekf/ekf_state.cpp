#include "slam/line_slam/ekf/ekf_state.hpp"

#include <algorithm>

#include "lcm_tools/base/check.hpp"
#include "slam/line_slam/ekf/subtract_square.hpp"

namespace marco::slam {
namespace {

using Eigen::Index;

constexpr Index kMeasurements = 64;  // room for a scan's rows at first

// First row of the state in the k-th block of a measurement.
Index start_of(const SparseRows& rows, int k) {
  return kBlockSize * rows.blocks[static_cast<std::size_t>(k)];
}

// Of the robot and these walls, packed.
std::vector<Index> rows_of(std::span<const int> walls) {
  std::vector<Index> rows{0, 1, 2};
  for (const int wall : walls) {
    for (Index i = 0; i < kBlockSize; ++i) rows.push_back(kBlockSize * wall + i);
  }
  return rows;
}

}  // namespace

EkfState::EkfState(const Eigen::Vector3d& robot, const Eigen::Matrix3d& covariance) {
  take_block();
  mean_.head<3>() = robot;
  first_.head<3>() = robot;
  p_.topLeftCorner<3, 3>() = covariance;
}

int EkfState::take_block() {
  if (!free_.empty()) {
    const int block = free_.back();
    free_.pop_back();
    return block;
  }
  const Index before = size(), after = before + kBlockSize;
  mean_.conservativeResize(after);
  first_.conservativeResize(after);
  mean_.tail<4>().setZero();
  first_.tail<4>().setZero();
  if (p_.rows() < after) {
    const Index room = 2 * after;
    p_.conservativeResize(room, room);
    p_.rightCols(room - before).setZero();
    p_.bottomRows(room - before).setZero();
  }
  return static_cast<int>(before / kBlockSize);
}

EkfState::Columns EkfState::columns_of(int block) const {
  const Index at = kBlockSize * block, below = size() - at;
  Columns columns(size(), kBlockSize);
  columns.topRows(at) = p_.block(at, 0, kBlockSize, at).transpose();
  columns.bottomRows(below) = p_.block(at, at, below, kBlockSize);
  return columns;
}

void EkfState::set_columns(int block, const Columns& columns) {
  const Index at = kBlockSize * block, below = size() - at;
  p_.block(at, 0, kBlockSize, at) = columns.topRows(at).transpose();
  p_.block(at, at, below, kBlockSize) = columns.bottomRows(below);
}

Eigen::Matrix4d EkfState::covariance(int block_a, int block_b) const {
  const auto [low, high] = std::minmax(block_a, block_b);
  const Eigen::Matrix4d below = p_.block<4, 4>(kBlockSize * high, kBlockSize * low);
  if (block_a < block_b) return below.transpose();
  return below;
}

void EkfState::predict(const Eigen::Vector3d& robot,
                       const Eigen::Matrix3d& jacobian,
                       const Eigen::Matrix3d& noise) {
  mean_.head<3>() = robot;
  first_.head<3>() = robot;
  auto columns = p_.block(0, 0, size(), 3);
  columns *= jacobian.transpose();
  const Eigen::Matrix3d own = jacobian * columns.topRows<3>() + noise;
  columns.topRows<3>() = 0.5 * (own + own.transpose());
}

Eigen::MatrixXd EkfState::covariance_with(const SparseRows& rows) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(size(), rows.rows());
  for (int k = 0; k < rows.num_blocks; ++k) {
    product += columns_of(rows.blocks[static_cast<std::size_t>(k)])
                   .lazyProduct(rows.jacobian.middleCols<4>(kBlockSize * k).transpose());
  }
  return product;
}

SparseRows::Square EkfState::covariance_between(const SparseRows& a, const SparseRows& b) const {
  SparseRows::Square product = SparseRows::Square::Zero(a.rows(), b.rows());
  for (int i = 0; i < a.num_blocks; ++i) {
    for (int j = 0; j < b.num_blocks; ++j) {
      product.noalias() +=
          a.jacobian.middleCols<4>(kBlockSize * i) *
          covariance(a.blocks[static_cast<std::size_t>(i)], b.blocks[static_cast<std::size_t>(j)]) *
          b.jacobian.middleCols<4>(kBlockSize * j).transpose();
    }
  }
  return product;
}

SparseRows::Square EkfState::innovation_covariance(const SparseRows& rows) const {
  const SparseRows::Square s = covariance_between(rows, rows) + rows.noise;
  return 0.5 * (s + s.transpose());
}

void EkfState::correct(const SparseRows& rows) {
  const Index m = rows.rows();
  if (num_u_ == 0) u_.resize(size(), std::max(u_.cols(), kMeasurements));
  if (u_.cols() < num_u_ + m) u_.conservativeResize(Eigen::NoChange, 2 * (num_u_ + m));
  // P H^T less U (H U)^T: the corrections before, which P does not hold yet.
  Eigen::MatrixXd h_u = Eigen::MatrixXd::Zero(m, num_u_);
  for (int k = 0; k < rows.num_blocks; ++k) {
    h_u += rows.jacobian.middleCols<4>(kBlockSize * k)
               .lazyProduct(u_.block(start_of(rows, k), 0, kBlockSize, num_u_));
  }
  Eigen::MatrixXd product = covariance_with(rows);
  for (Index k = 0; k < num_u_; ++k) product -= u_.col(k).lazyProduct(h_u.col(k).transpose());
  SparseRows::Square s = rows.noise;  // (5.36)
  for (int k = 0; k < rows.num_blocks; ++k) {
    s += rows.jacobian.middleCols<4>(kBlockSize * k)
             .lazyProduct(product.middleRows<4>(start_of(rows, k)));
  }
  const SparseRows::Square root = inverse_root(s);
  auto u = u_.middleCols(num_u_, m);
  u = product.lazyProduct(root.transpose());
  mean_ += u.lazyProduct(root.lazyProduct(rows.innovation));  // K nu, (5.34)
  num_u_ += m;
}

void EkfState::finish_corrections() {
  subtract_square(u_.leftCols(num_u_), p_);
  num_u_ = 0;
}

int EkfState::append(const Eigen::Vector4d& mean,
                     const Eigen::Vector4d& first_estimate,
                     const Eigen::Matrix<double, 4, 3>& jacobian_robot,
                     const Eigen::Matrix4d& noise) {
  const int block = take_block();
  mean_.segment<4>(kBlockSize * block) = mean;
  first_.segment<4>(kBlockSize * block) = first_estimate;
  Columns columns = p_.block(0, 0, size(), 3) * jacobian_robot.transpose();
  const Eigen::Matrix4d own = jacobian_robot * columns.topRows<3>() + noise;
  columns.middleRows<4>(kBlockSize * block) = 0.5 * (own + own.transpose());
  set_columns(block, columns);
  return block;
}

void EkfState::replace(int block,
                       const SparseRows& change,
                       const Eigen::Vector4d& mean,
                       const Eigen::Vector4d& first_estimate) {
  Columns columns = covariance_with(change);
  Eigen::Matrix4d own = change.noise;
  for (int k = 0; k < change.num_blocks; ++k) {
    own +=
        change.jacobian.middleCols<4>(kBlockSize * k) * columns.middleRows<4>(start_of(change, k));
  }
  columns.middleRows<4>(kBlockSize * block) = 0.5 * (own + own.transpose());
  set_columns(block, columns);
  mean_.segment<4>(kBlockSize * block) = mean;
  first_.segment<4>(kBlockSize * block) = first_estimate;
}

void EkfState::remove(int block) {
  require(block > 0, "ekf_state: only a wall can be removed");
  free_.push_back(block);
}

Eigen::VectorXd EkfState::dense_mean(std::span<const int> walls) const {
  return mean_(rows_of(walls));
}

Eigen::MatrixXd EkfState::dense_covariance(std::span<const int> walls) const {
  const std::vector<Index> rows = rows_of(walls);
  const auto n = static_cast<Index>(rows.size());
  return Eigen::MatrixXd::NullaryExpr(n, n, [&](Index i, Index j) {
    const auto [low, high] =
        std::minmax(rows[static_cast<std::size_t>(i)], rows[static_cast<std::size_t>(j)]);
    return p_(high, low);
  });
}

void EkfState::restore(std::span<const int> walls,
                       const Eigen::VectorXd& mean,
                       const Eigen::VectorXd& first_estimate,
                       const Eigen::MatrixXd& covariance) {
  const std::vector<Index> rows = rows_of(walls);
  require(mean.size() == static_cast<Index>(rows.size()) && first_estimate.size() == mean.size() &&
              covariance.rows() == mean.size() && covariance.cols() == mean.size(),
          "ekf_state: stored sizes do not agree");
  mean_(rows) = mean;
  first_(rows) = first_estimate;
  p_(rows, rows) = covariance;
}

}  // namespace marco::slam
