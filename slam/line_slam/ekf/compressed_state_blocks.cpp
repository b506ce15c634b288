#include "slam/line_slam/ekf/compressed_state.hpp"

#include <algorithm>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {

using Eigen::Index;

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

}  // namespace marco::slam
