#include "slam/line_slam/ekf/state_blocks.hpp"

namespace marco::slam {

int StateBlocks::take() {
  int block = size();
  if (free_.empty()) {
    place_.push_back(-1);
    live_.push_back(0);
  } else {
    block = free_.back();
    free_.pop_back();
  }
  live_[static_cast<std::size_t>(block)] = 1;
  place_[static_cast<std::size_t>(block)] = static_cast<int>(active_.size());
  active_.push_back(block);
  ++num_live_;
  return block;
}

void StateBlocks::activate(std::span<const int> blocks) {
  for (const int block : active_) place_[static_cast<std::size_t>(block)] = -1;
  active_.assign(1, 0);
  active_.insert(active_.end(), blocks.begin(), blocks.end());
  for (std::size_t k = 0; k < active_.size(); ++k) {
    place_[static_cast<std::size_t>(active_[k])] = static_cast<int>(k);
  }
}

void StateBlocks::free(int block) {
  const int hole = place_[static_cast<std::size_t>(block)], last = active_.back();
  active_[static_cast<std::size_t>(hole)] = last;
  place_[static_cast<std::size_t>(last)] = hole;
  active_.pop_back();
  place_[static_cast<std::size_t>(block)] = -1;
  live_[static_cast<std::size_t>(block)] = 0;
  free_.push_back(block);
  --num_live_;
}

void StateBlocks::add_times_rows(const ConstMatrixPart& columns,
                                 const SparseRows& rows,
                                 Eigen::MatrixXd& product) const {
  for (int k = 0; k < rows.num_blocks; ++k) {
    add_product(1.0, columns.middleCols(row_of(rows.blocks[static_cast<std::size_t>(k)]), 4),
                rows.jacobian.middleCols(kBlockSize * k, 4), product);
  }
}

}  // namespace marco::slam
