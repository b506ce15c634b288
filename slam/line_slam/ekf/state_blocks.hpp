#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "slam/line_slam/ekf/add_product.hpp"
#include "slam/line_slam/ekf/sparse_rows.hpp"

namespace marco::slam {

/// Which blocks of four numbers the state has, and the order of the active ones in matrices of the
/// active part. Block 0 is the robot: always live and always the first active one.
class StateBlocks {
 public:
  int size() const { return static_cast<int>(place_.size()); }
  bool is_live(int block) const { return live_[static_cast<std::size_t>(block)] != 0; }
  bool is_active(int block) const { return place_[static_cast<std::size_t>(block)] >= 0; }
  std::span<const int> active() const { return active_; }
  int num_passive() const { return num_live_ - static_cast<int>(active_.size()); }
  /// Rows of the active part.
  Eigen::Index active_rows() const { return 4 * static_cast<Eigen::Index>(active_.size()); }
  /// First row of an active block.
  Eigen::Index row_of(int block) const {
    return kBlockSize * place_[static_cast<std::size_t>(block)];
  }

  /// A live, active block: a free one, or else a new one at the end.
  int take();
  /// Makes exactly the robot and these blocks active.
  void activate(std::span<const int> blocks);
  /// Frees an active block; the last active one takes its place.
  void free(int block);

  /// product += columns H^T, over the columns of the rows' blocks.
  void add_times_rows(const ConstMatrixPart& columns,
                      const SparseRows& rows,
                      Eigen::MatrixXd& product) const;

 private:
  std::vector<int> place_{0};  ///< per block: place among the active ones, or -1
  std::vector<char> live_{1};  ///< per block
  std::vector<int> free_;
  std::vector<int> active_{0};  ///< blocks
  int num_live_ = 1;
};

}  // namespace marco::slam
