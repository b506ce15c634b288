#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

namespace marco::slam {

/// A large symmetric matrix that is changed in two ways: a few rows and columns are rewritten, or
/// P -= V V^T over all of it. The second is deferred: the lower triangle is stored in tiles of
/// 64 x 64. Each tile knows how many columns of the collected V it has subtracted, and subtracts
/// the rest when it is read or in catch_up(). Growing copies nothing.
///
/// Rows come in blocks of four (a wall's two end points; the robot's three and one unused).
/// Not thread-safe.
class TiledCovariance {
 public:
  static constexpr int kBlock = 4;
  static constexpr int kTile = 64;

  int num_blocks() const { return num_blocks_; }
  int size() const { return kBlock * num_blocks_; }

  /// New rows and columns are zero. Never shrinks.
  void grow_to(int num_blocks);

  /// Up-to-date columns of the given blocks. @param columns size() x 4*blocks.size(), overwritten.
  void read(std::span<const int> blocks, Eigen::MatrixXd& columns);

  /// One up-to-date 4 x 4 block.
  Eigen::Matrix4d read(int block_a, int block_b);

  /// Overwrites the columns of the given blocks and, the matrix being symmetric, their rows.
  void write(std::span<const int> blocks, const Eigen::MatrixXd& columns);

  /// P -= v v^T, deferred. @param v size() rows, zero in blocks that do not change.
  void subtract_outer(const Eigen::MatrixXd& v);

  /// Updates up to `max_tiles` tiles. @returns how many were updated.
  int catch_up(int max_tiles);

  /// Columns of V waiting; 0 = everything is up to date.
  int pending() const { return pending_; }
  int num_tiles() const { return static_cast<int>(tiles_.size()); }

 private:
  using TileMatrix = Eigen::Matrix<double, kTile, kTile>;
  struct Tile {
    std::unique_ptr<TileMatrix> values;
    int taken = 0;  ///< columns of V already subtracted
  };
  Tile& tile(int row, int column) { return tiles_[static_cast<std::size_t>(index(row, column))]; }
  static int index(int row, int column) { return row * (row + 1) / 2 + column; }
  void bring_up_to_date(int row, int column);
  void forget_taken();

  int num_blocks_ = 0;
  int num_tile_rows_ = 0;
  std::vector<Tile> tiles_;         ///< (0,0) (1,0) (1,1) (2,0) ...; diagonal ones in full
  std::vector<Eigen::MatrixXd> v_;  ///< per row of tiles: 64 x pending_
  int pending_ = 0;
  int next_tile_ = 0;
};

}  // namespace marco::slam
