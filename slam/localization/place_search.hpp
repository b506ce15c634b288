#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "slam/matching/correlative_matcher.hpp"

namespace marco::slam {

/// One coarse level of a likelihood pyramid, laid out so that the blocks of a row that one point
/// falls into stand side by side: many blocks are bounded at once. Made once a map. Const: safe
/// from several threads.
class BlockTable {
 public:
  /// The finest level that has no more blocks than `max_blocks`, or the coarsest.
  BlockTable(const LikelihoodPyramid& map, int max_blocks);

  int level() const { return level_; }
  /// Blocks whose poses lie in the map, from cell (0, 0).
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// Of a row of sums: columns() and some more, so that 16 can be added at once.
  int stride() const { return columns_ + kLanes; }
  /// Adds the likelihood's bound for a point this many cells from the pose, to each block.
  void add(int x_cells, int y_cells, uint16_t* sums) const;

 private:
  static constexpr int kLanes = 16;

  int level_ = 0;
  int columns_ = 0;
  int rows_ = 0;
  int first_ = 0;  ///< blocks before cell (0, 0) that the table begins at
  int width_ = 0;  ///< blocks in a row of the table, without its padding
  int height_ = 0;
  std::vector<uint8_t> values_;  ///< by y and x within a block, then by block row and column
};

/// All poses of a scan in a whole map, at all headings, whose mean likelihood comes near the best:
/// branch and bound over blocks of cells. The lattice is the map's, turns move a point at half the
/// scan's reach by a cell. Used once.
class PlaceSearch {
 public:
  struct Limits {
    double min_score;    ///< mean likelihood, 0..1
    double keep_within;  ///< of the best
  };

  static constexpr int kMaxPoints = 256;

  /// @param map, blocks  of one map; outlive the search.
  /// @param points  2xN [m], 1 <= N <= kMaxPoints, about their own middle
  PlaceSearch(const LikelihoodPyramid& map,
              const BlockTable& blocks,
              const Points2& points,
              const Limits& limits);

  /// @returns map_from_points, best first, one for each square metre and 20 degrees at most.
  std::vector<Pose2> run(std::size_t max_count);

 private:
  struct Block {
    int turn;
    int x;  ///< of the middle, fine cells
    int y;
    int sum;  ///< upper bound of the points' likelihoods
  };
  struct Offset {
    int x;
    int y;
  };
  using Turned = std::vector<Offset>;
  std::vector<Block> bounded_blocks() const;
  Block scored(int level, Block block) const;
  void branch(int level, std::span<Block> blocks);
  void keep(const Block& place);
  int threshold() const;

  const LikelihoodPyramid& map_;
  const BlockTable& blocks_;
  std::vector<double> thetas_rad_;
  std::vector<Turned> turned_;  ///< the points in cells about their middle, one a heading
  int points_;
  int min_sum_ = 0;
  int keep_within_ = 0;
  int best_sum_ = 0;
  std::unordered_map<uint64_t, Block> buckets_;  ///< the best place of each
};

}  // namespace marco::slam
