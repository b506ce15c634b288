#pragma once

#include <cstddef>
#include <vector>

namespace marco::mapping3d {

/// The lines along one of a scanner's two angles on which its beams lie: the rings of a laser that
/// spins, the columns of one that is turned.
class ScanLines {
 public:
  /// Even lines from `first_rad` on.
  ScanLines(double first_rad, double step_rad, std::size_t count);
  /// @param lines_rad  ascending, at least two
  explicit ScanLines(std::vector<double> lines_rad);

  std::size_t count() const { return count_; }
  /// The nearest line.
  std::size_t at(double angle_rad) const;
  double angle_rad(std::size_t line) const;
  /// Between neighbours; of uneven ones the median.
  double step_rad() const { return step_rad_; }

 private:
  double first_rad_ = 0.0;
  double step_rad_;
  std::size_t count_;
  std::vector<double> lines_rad_;  ///< empty: even
};

/// Finds the lines on which nearly all of the angles lie: gaps between lines are several times as
/// wide as any within one. Angles of near points jitter most, so give those of far ones. O(n log
/// n).
/// @returns nothing where the angles lie anywhere.
std::vector<double> find_lines(std::vector<double> angles_rad);

/// The lines, and where steps are missing between and beyond them those on which any of these
/// angles lie: the far points, of which lines are found, need not lie in every direction.
std::vector<double> complete_lines(const std::vector<double>& lines_rad,
                                   const std::vector<double>& all_angles_rad);

}  // namespace marco::mapping3d
