#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/matching/line_fit.hpp"

namespace marco::slam {

struct CalculatedPointsOptions {
  int max_neighbours = 40;        ///< points that may join the three, both sides together (n)
  double near_line_m = 0.05;      ///< a neighbour farther from the line is skipped
  double good_fit_m = 0.02;       ///< a line with a larger rms error is not used
  double max_gap_m = 0.5;         ///< largest gap between the three points that seed a line
  double course_m = 0.3;          ///< half length of the piece of wall whose direction counts
  double error_growth_m = 0.002;  ///< tolerated growth of the rms error: by chance three points
                                  ///< look straighter than the wall they lie on

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_neighbours", max_neighbours, Limits{0, 1000});
    v("near_line_m", near_line_m, kPositive);
    v("good_fit_m", good_fit_m, kPositive);
    v("max_gap_m", max_gap_m, kPositive);
    v("course_m", course_m, kPositive);
    v("error_growth_m", error_growth_m, kNotNegative);
  }
};

/// The calculated points of thesis B, ch. 3.4.3 and app. E.3: about each point of a scan a line is
/// grown from it and its two neighbours (at the ends of the scan from the last three) by principal
/// components; neighbours left and right join while they lie near the line and the error of the fit
/// does not grow. All lines are fitted once, when built. Const members are safe from several
/// threads.
class CalculatedPoints {
 public:
  struct Partner {
    Eigen::Vector2d point;  ///< what to match against [m]
    const Line* line;       ///< null for the raw point; lives as long as this object
  };

  /// @param points 2×N [m] in the order of the sweep, finite.
  explicit CalculatedPoints(const Points2& points, CalculatedPointsOptions options = {});

  /// The correspondence of `query`, whose nearest scan point is `nearest` (0 <= nearest < N): its
  /// projection on the line there if that line is good and the projection nearer, else the point.
  Partner partner(const Eigen::Vector2d& query, int nearest) const;

  /// The line about a point, or null where none fits well (fewer than 3 points, a corner, a gap).
  const Line* line(int index) const { return good_[index] ? &lines_[index] : nullptr; }

  /// The direction of the points within `course_m` (at least three): unobservable for a covariance.
  /// Wider than `line`, since the direction of a few noisy points close together is chance and
  /// would add false information along a wall. Null at corners and below 3 points.
  const Line* course(int index) const { return straight_[index] ? &courses_[index] : nullptr; }

  /// Whether both neighbours lie within `max_gap_m`: next to a jump the shape is unknown.
  bool embedded(int index) const { return embedded_[index]; }

 private:
  void grow(int index);
  void follow(int index);

  CalculatedPointsOptions options_;
  Points2 points_;
  std::vector<Line> lines_;
  std::vector<char> good_;
  std::vector<Line> courses_;
  std::vector<char> straight_;
  std::vector<char> embedded_;
};

}  // namespace marco::slam
