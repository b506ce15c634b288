#pragma once

#include <vector>

#include "slam/line_slam/lines/observed_wall.hpp"
#include "slam/line_slam/lines/split_and_merge.hpp"

namespace marco::slam {

/// Fits lines to pieces and makes observed walls of them. The regression (4.2), which breaks down
/// for steep walls, is replaced by a total least squares fit, weighted by each beam's error across
/// the wall, which also gives the covariance.
class WallFitter {
 public:
  explicit WallFitter(const LineExtractorOptions& options) : options_(options) {}

  /// Appends the wall of pieces[index], or two where it has a step, or none where too few points
  /// agree. @param points, walls are referred to during the call only.
  void fit(const ScanPoints& points,
           const std::vector<LinePiece>& pieces,
           std::size_t index,
           std::vector<ObservedWall>& walls);

 private:
  /// A point of the wall being fitted.
  struct Member {
    int point = 0;
    double weight = 0.0;  ///< 1 / variance across the wall
  };

  void choose_members(int from, int to, const FittedLine& line);
  void cut_members_at_gaps(const FittedLine& line);
  bool is_gap_between(int before, int after, const FittedLine& line) const;
  FittedLine fit_members() const;
  double chi2_of(const FittedLine& line) const;
  std::size_t find_step(const FittedLine& line) const;
  void add_parts(const FittedLine& line, std::vector<ObservedWall>& walls);
  void add_wall(const FittedLine& fitted, std::vector<ObservedWall>& walls) const;
  double spacing_m(const Member& at, const Member& inwards) const;
  bool end_is_seen(int beam, int step, const ObservedWall& wall) const;

  LineExtractorOptions options_;
  const ScanPoints* points_ = nullptr;
  std::vector<Member> members_, rest_;
};

}  // namespace marco::slam
