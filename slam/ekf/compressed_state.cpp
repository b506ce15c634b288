#include "slam/ekf/compressed_state.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "common/check.hpp"

namespace marco::slam {
namespace {

using Eigen::Index;

// So many columns of W^T are kept before their sum of squares is taken: large enough for a product
// of matrices to pay, small enough to stay in cache.
constexpr Index kMaxWeights = 192;

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

int CompressedState::take_block() {
  int block = static_cast<int>(local_.size());
  if (!free_.empty()) {
    block = free_.back();
    free_.pop_back();
  } else {
    local_.push_back(-1);
    live_.push_back(0);
    mean_.conservativeResize(4 * (block + 1));
    first_.conservativeResize(4 * (block + 1));
    whole_.grow_to(block + 1);
  }
  live_[static_cast<std::size_t>(block)] = 1;
  mean_.segment<4>(4 * block).setZero();
  first_.segment<4>(4 * block).setZero();
  ++num_walls_;
  return block;
}

void CompressedState::reserve_local(Index size) {
  if (p_.rows() >= size) return;
  const Index room = std::max<Index>(2 * p_.rows(), std::max<Index>(size, 64));
  const Index old = p_.rows();
  p_.conservativeResize(room, room);
  p_.rightCols(room - old).setZero();
  p_.bottomRows(room - old).setZero();
  u_.conservativeResize(room, std::max<Index>(u_.cols(), 64));
  if (has_passive_) phi_t_.conservativeResize(phi_t_.rows(), room);
}

Eigen::Vector4d CompressedState::mean(int block) const {
  Eigen::Vector4d value = mean_.segment<4>(4 * block);
  if (has_passive_ && !is_active(block)) {
    value += passive_with_active_.middleRows<4>(4 * block) * theta_;
  }
  return value;
}

Eigen::Matrix4d CompressedState::covariance(int block_a, int block_b) const {
  return p_.block<4, 4>(at(block_a), at(block_b));
}

Eigen::Matrix4d CompressedState::marginal(int block) {
  if (is_active(block)) return covariance(block, block);
  Eigen::Matrix4d value = whole_.read(block, block);
  const auto row = passive_with_active_.middleRows<4>(4 * block);
  const Eigen::MatrixXd weighted = row * weights_t_.leftCols(num_weights_);
  value -= weighted * weighted.transpose();
  if (has_psi_) {
    const Eigen::MatrixXd with_psi = psi_.selfadjointView<Eigen::Lower>() * row.transpose();
    value -= row * with_psi;
  }
  return value;
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

int CompressedState::append(const Eigen::Vector4d& mean,
                            const Eigen::Vector4d& first_estimate,
                            const Eigen::Matrix<double, 4, 3>& jacobian_robot,
                            const Eigen::Matrix4d& noise) {
  const int block = take_block();
  const Index n = local_size();
  local_[static_cast<std::size_t>(block)] = static_cast<int>(active_.size());
  active_.push_back(block);
  reserve_local(n + 4);
  mean_.segment<4>(4 * block) = mean;
  first_.segment<4>(4 * block) = first_estimate;
  const Eigen::MatrixXd column = p_.block(0, 0, n, 3) * jacobian_robot.transpose();
  const Eigen::Matrix4d own = jacobian_robot * column.topRows<3>() + noise;
  p_.block(0, n, n, 4) = column;
  p_.block(n, 0, 4, n) = column.transpose();
  p_.block<4, 4>(n, n) = 0.5 * (own + own.transpose());
  if (has_passive_) {
    phi_t_.middleCols<4>(n) = phi_t_.leftCols<3>() * jacobian_robot.transpose();
    const Index rows = passive_with_active_.rows();
    if (rows < whole_.size()) {
      passive_with_active_.conservativeResize(whole_.size(), Eigen::NoChange);
      passive_with_active_.bottomRows(whole_.size() - rows).setZero();
    }
  }
  return block;
}

void CompressedState::replace(int block,
                              const SparseRows& change,
                              const Eigen::Vector4d& mean,
                              const Eigen::Vector4d& first_estimate) {
  const Index n = local_size(), to = at(block);
  const Eigen::MatrixXd column = covariance_with(change);
  Eigen::Matrix4d own = change.noise;
  for (int k = 0; k < change.num_blocks; ++k) {
    own += change.jacobian.middleCols(4 * k, 4) *
           column.middleRows<4>(at(change.blocks[static_cast<std::size_t>(k)]));
  }
  if (has_passive_) {
    Eigen::MatrixXd phi = Eigen::MatrixXd::Zero(phi_t_.rows(), 4);
    for (int k = 0; k < change.num_blocks; ++k) {
      phi += phi_t_.middleCols(at(change.blocks[static_cast<std::size_t>(k)]), 4) *
             change.jacobian.middleCols(4 * k, 4).transpose();
    }
    phi_t_.middleCols<4>(to) = phi;
  }
  p_.block(0, to, n, 4) = column;
  p_.block(to, 0, 4, n) = column.transpose();
  p_.block<4, 4>(to, to) = 0.5 * (own + own.transpose());
  mean_.segment<4>(4 * block) = mean;
  first_.segment<4>(4 * block) = first_estimate;
}

void CompressedState::remove(int block) {
  require(block > 0 && is_active(block), "compressed_state: only an active wall can be removed");
  drop_local(local_[static_cast<std::size_t>(block)]);
  local_[static_cast<std::size_t>(block)] = -1;
  live_[static_cast<std::size_t>(block)] = 0;
  free_.push_back(block);
  --num_walls_;
  if (has_passive_) passive_with_active_.middleRows<4>(4 * block).setZero();
}

void CompressedState::drop_local(int place) {
  const Index n = local_size(), hole = 4 * place, last = n - 4;
  if (hole != last) {
    p_.block(0, hole, n, 4) = p_.block(0, last, n, 4).eval();
    p_.block(hole, 0, 4, n) = p_.block(last, 0, 4, n).eval();
    if (has_passive_) phi_t_.middleCols<4>(hole) = phi_t_.middleCols<4>(last).eval();
    const int moved = active_.back();
    active_[static_cast<std::size_t>(place)] = moved;
    local_[static_cast<std::size_t>(moved)] = place;
  }
  active_.pop_back();
}

// A matrix X with X X^T = W^T W of everything collected.
Eigen::MatrixXd CompressedState::weight_factor() const {
  if (!has_psi_) return weights_t_.leftCols(num_weights_);
  Eigen::MatrixXd psi = psi_;
  if (num_weights_ > 0) {  // Eigen divides by the number of columns
    psi.selfadjointView<Eigen::Lower>().rankUpdate(weights_t_.leftCols(num_weights_));
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(psi);
  const Eigen::VectorXd root = factor.vectorD().cwiseMax(0.0).cwiseSqrt();
  Eigen::MatrixXd lower = factor.matrixL();
  lower = lower * root.asDiagonal();
  return factor.transpositionsP().transpose() * lower;
}

void CompressedState::store() {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(whole_.size(), local_size());
  if (has_passive_) {
    columns.noalias() = passive_with_active_ * phi_t_.leftCols(local_size());
    refresh_means();
    const Eigen::MatrixXd factor = weight_factor();
    if (factor.cols() > 0) whole_.subtract_outer(passive_with_active_ * factor);
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
