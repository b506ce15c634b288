#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::slam {

struct CorrelativeMatcherOptions {
  double resolution_m = 0.05;  ///< of the finest level and of the result
  double blur_m = 0.05;        ///< standard deviation of a wall's likelihood
  int levels = 5;              ///< each at half the resolution of the one before
  int max_points = 120;        ///< scored points of the scan, evenly chosen

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced(
        "resolution_m", resolution_m, Limits{0.005, 0.5},
        "Cell size of the exhaustive search. More for large, plain halls: faster and less exact.");
    v.advanced(
        "max_points", max_points, Limits{10, 10000},
        "Number of points that the exhaustive search scores. More for cluttered rooms: slower.");
  }
};

/// Walls are blurred more where ranges are noisier than 3 cm.
CorrelativeMatcherOptions adapted(CorrelativeMatcherOptions options, double range_sigma_m);

/// All poses within these half-widths about a centre.
struct SearchWindow {
  Pose2 map_from_robot_centre;
  double half_width_m = 1.0;
  double half_turn_rad = 0.35;
  /// Subtracted from the score at the window's edge, less towards the centre by the square of the
  /// distance (the logarithm of a Gaussian): of similar poses the one nearest to the centre wins.
  double penalty_at_edge = 0.0;
  /// Poses this near, in x, y and heading, are not looked at.
  struct Excluded {
    Pose2 map_from_robot;
    double half_width_m;
    double half_turn_rad;
  };
  std::optional<Excluded> excluded = {};
};

struct CorrelativeMatch {
  Pose2 map_from_robot;
  double score = 0.0;  ///< mean likelihood of the points, 0..1, without the penalty
  double penalty = 0.0;
};

/// Points farther off than this along an axis are left out of a search.
inline constexpr double kSearchReachM = 40.0;

/// The points within `reach_m` of a place along both axes, in their order. Far points need a large
/// table and help little, since one step of the search's turn moves them by cells.
Points2 points_within(double reach_m, const Eigen::Vector2d& centre_m, const Points2& points);

/// The map's likelihood at one resolution and, above it, the largest likelihood of each block of
/// cells that a coarse cell can reach.
class LikelihoodPyramid {
 public:
  /// @param points_in_map  2xN [m]
  LikelihoodPyramid(const Points2& points_in_map, const CorrelativeMatcherOptions& options);

  int levels() const { return static_cast<int>(levels_.size()); }
  /// Largest likelihood 0..255 in the block of 2^level x 2^level fine cells that starts at (x, y).
  int at(int level, int x_cell, int y_cell) const {
    // The table is padded by the largest block, so that one unsigned comparison an axis is enough.
    const auto x = static_cast<unsigned>(x_cell + pad_), y = static_cast<unsigned>(y_cell + pad_);
    if (x >= width_ || y >= height_) return 0;
    return levels_[static_cast<std::size_t>(level)][y * width_ + x];
  }
  Eigen::Vector2d origin_m() const { return origin_m_; }
  double resolution_m() const { return resolution_m_; }
  /// Size of the table from the origin; the likelihood beyond it is 0.
  int width_cells() const { return static_cast<int>(width_); }
  int height_cells() const { return static_cast<int>(height_); }

 private:
  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  double resolution_m_;
  int pad_;
  unsigned width_ = 0;
  unsigned height_ = 0;
  std::vector<std::vector<uint8_t>> levels_;
};

/// Correlative scan matching by branch and bound (Hess et al., ICRA 2016, algorithm 3; the score is
/// Olson's, ICRA 2009, as a mean of likelihoods): finds the best pose of the window's lattice, a
/// guaranteed optimum. Lattice: resolution_m along x and y, and turns that move the farthest point
/// by one cell. Const: safe from several threads.
class CorrelativeMatcher {
 public:
  explicit CorrelativeMatcher(const CorrelativeMatcherOptions& options = {});

  /// @param min_score  least score after the penalty
  /// @returns score 0 and the window's centre when nothing was found.
  CorrelativeMatch search(const LikelihoodPyramid& map,
                          const Points2& points_in_robot,
                          const SearchWindow& window,
                          double min_score) const;

  const CorrelativeMatcherOptions& options() const { return options_; }

 private:
  CorrelativeMatcherOptions options_;
};

}  // namespace marco::slam
