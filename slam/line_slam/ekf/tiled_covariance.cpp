#include "slam/line_slam/ekf/tiled_covariance.hpp"

#include <algorithm>

#include "slam/line_slam/ekf/add_product.hpp"

namespace marco::slam {
namespace {

constexpr int kBlocksPerTile = TiledCovariance::kTile / TiledCovariance::kBlock;

}  // namespace

void TiledCovariance::grow_to(int num_blocks) {
  num_blocks_ = std::max(num_blocks_, num_blocks);
  const int tile_rows = (num_blocks_ + kBlocksPerTile - 1) / kBlocksPerTile;
  for (; num_tile_rows_ < tile_rows; ++num_tile_rows_) {
    for (int column = 0; column <= num_tile_rows_; ++column) {
      tiles_.push_back({std::make_unique<TileMatrix>(TileMatrix::Zero()), pending_});
    }
    v_.push_back(Eigen::MatrixXd::Zero(kTile, pending_));
  }
}

void TiledCovariance::bring_up_to_date(int row, int column) {
  Tile& tile = this->tile(row, column);
  const int missing = pending_ - tile.taken;
  if (missing == 0) return;
  const Eigen::MatrixXd& left = v_[static_cast<std::size_t>(row)];
  const Eigen::MatrixXd& right = v_[static_cast<std::size_t>(column)];
  add_product(-1.0, left.rightCols(missing), right.rightCols(missing), *tile.values);
  tile.taken = pending_;
}

// The tiles are not updated: a whole tile for a few of its columns is work for catch_up().
void TiledCovariance::read(std::span<const int> blocks, Eigen::MatrixXd& columns) {
  columns.resize(size(), kBlock * static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const int tile_column = blocks[k] / kBlocksPerTile;
    const int within = kBlock * (blocks[k] % kBlocksPerTile);
    const auto mine = v_[static_cast<std::size_t>(tile_column)].middleRows(within, kBlock);
    const Eigen::Index to = kBlock * static_cast<Eigen::Index>(k);
    for (int t = 0; t < num_tile_rows_; ++t) {
      const int rows = std::min(kTile, size() - t * kTile);
      const Tile& tile = this->tile(std::max(t, tile_column), std::min(t, tile_column));
      auto values = columns.block(Eigen::Index{t} * kTile, to, rows, kBlock);
      if (t >= tile_column) {
        values = tile.values->block(0, within, rows, kBlock);
      } else {
        values = tile.values->block(within, 0, kBlock, rows).transpose();
      }
      const int missing = pending_ - tile.taken;
      if (missing == 0) continue;
      add_product(-1.0, v_[static_cast<std::size_t>(t)].topRows(rows).rightCols(missing),
                  mine.rightCols(missing), values);
    }
  }
}

Eigen::Matrix4d TiledCovariance::read(int block_a, int block_b) {
  const int row = std::max(block_a, block_b), column = std::min(block_a, block_b);
  bring_up_to_date(row / kBlocksPerTile, column / kBlocksPerTile);
  Eigen::Matrix4d values =
      tile(row / kBlocksPerTile, column / kBlocksPerTile)
          .values->block<kBlock, kBlock>(kBlock * Eigen::Index{row % kBlocksPerTile},
                                         kBlock * Eigen::Index{column % kBlocksPerTile});
  if (block_a < block_b) return values.transpose();
  return values;
}

void TiledCovariance::write(std::span<const int> blocks, const Eigen::MatrixXd& columns) {
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const int tile_column = blocks[k] / kBlocksPerTile;
    const int within = kBlock * (blocks[k] % kBlocksPerTile);
    const Eigen::Index from = kBlock * static_cast<Eigen::Index>(k);
    for (int t = 0; t < num_tile_rows_; ++t) {
      const int rows = std::min(kTile, size() - t * kTile);
      const auto values = columns.block(Eigen::Index{t} * kTile, from, rows, kBlock);
      if (t >= tile_column) {
        tile(t, tile_column).values->block(0, within, rows, kBlock) = values;
      }
      if (t <= tile_column) {
        tile(tile_column, t).values->block(within, 0, kBlock, rows) = values.transpose();
      }
    }
    // The written rows are up to date: no deferred change may apply to them.
    v_[static_cast<std::size_t>(tile_column)].middleRows(within, kBlock).setZero();
  }
}

void TiledCovariance::subtract_outer(const Eigen::MatrixXd& v) {
  forget_taken();
  for (int t = 0; t < num_tile_rows_; ++t) {
    const int rows = std::min(kTile, size() - t * kTile);
    Eigen::MatrixXd& mine = v_[static_cast<std::size_t>(t)];
    mine.conservativeResize(kTile, pending_ + v.cols());
    mine.rightCols(v.cols()).setZero();
    mine.block(0, pending_, rows, v.cols()) = v.middleRows(Eigen::Index{t} * kTile, rows);
  }
  pending_ += static_cast<int>(v.cols());
  next_tile_ = 0;
}

int TiledCovariance::catch_up(int max_tiles) {
  if (pending_ == 0) return 0;
  int done = 0;
  for (int row = 0, at = 0; row < num_tile_rows_; ++row) {
    for (int column = 0; column <= row; ++column, ++at) {
      if (at < next_tile_ || tile(row, column).taken == pending_) continue;
      if (done == max_tiles) return done;
      bring_up_to_date(row, column);
      next_tile_ = at + 1;
      ++done;
    }
  }
  forget_taken();
  return done;
}

void TiledCovariance::forget_taken() {
  const auto behind = std::any_of(tiles_.begin(), tiles_.end(),
                                  [this](const Tile& tile) { return tile.taken != pending_; });
  if (behind) return;
  for (Tile& tile : tiles_) tile.taken = 0;
  for (Eigen::MatrixXd& v : v_) v.resize(kTile, 0);
  pending_ = 0;
}

}  // namespace marco::slam
