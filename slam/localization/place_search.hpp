#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "slam/matching/correlative_matcher.hpp"

namespace marco::slam {

/// All poses of a scan in a whole map, at all headings, whose mean likelihood comes near the best:
/// branch and bound over blocks of cells. The lattice is the map's, turns move a point at half the
/// scan's reach by a cell. Used once.
class PlaceSearch {
 public:
  struct Limits {
    double min_score;    ///< mean likelihood, 0..1
    double keep_within;  ///< of the best
  };

  /// @param map  outlives the search. @param points  2xN [m], N >= 1, about their own middle
  PlaceSearch(const LikelihoodPyramid& map, const Points2& points, const Limits& limits);

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
  Block scored(int level, Block block) const;
  void branch(int level, std::span<Block> blocks);
  void keep(const Block& place);
  int threshold() const;

  const LikelihoodPyramid& map_;
  std::vector<double> thetas_rad_;
  std::vector<Turned> turned_;  ///< the points in cells about their middle, one a heading
  int points_;
  int min_sum_ = 0;
  int keep_within_ = 0;
  int best_sum_ = 0;
  std::unordered_map<uint64_t, Block> buckets_;  ///< the best place of each
};

}  // namespace marco::slam
