#pragma once

#include <vector>

#include "slam/line_slam/lines/fitted_line.hpp"
#include "slam/line_slam/lines/line_extractor_options.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::slam {

/// The points of one scan, in order of bearing, without the beams that returned nothing. Keeps its
/// memory from scan to scan.
class ScanPoints {
 public:
  explicit ScanPoints(const LineExtractorOptions& options) : options_(options) {}

  /// @param scan is referred to until the next call.
  void take(const ScanInRobot& scan);

  const ScanInRobot& scan() const { return *scan_; }
  int size() const { return static_cast<int>(x_.size()); }
  double x(int i) const { return x_[at(i)]; }
  double y(int i) const { return y_[at(i)]; }
  double range2(int i) const { return range2_[at(i)]; }
  double inverse_range2(int i) const { return inverse_range2_[at(i)]; }
  int beam(int i) const { return beam_[at(i)]; }
  /// Squared distance to the next point.
  double gap2(int i) const { return gap2_[at(i)]; }

  double squared_distance(int a, int b) const { return square(x(b) - x(a)) + square(y(b) - y(a)); }
  double across_of(const FittedLine& line, int i) const { return line.across_of(x(i), y(i)); }
  double along_of(const FittedLine& line, int i) const { return line.along_of(x(i), y(i)); }

  /// Sums of the points first..last, all of weight 1. O(1).
  LineSums sums_of(int first, int last) const;
  /// Whether the points first..last lie within split_distance_m of the line.
  bool lie_on(int first, int last, const FittedLine& line) const;

  /// Whether a wall ends between this point and the next one.
  bool is_gap_after(int point) const;
  /// Whether beams between the two points passed through the line and hit something behind it: a
  /// door, not outliers. A single such beam may be an outlier.
  bool is_opening(int before, int after, const FittedLine& line) const;

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  LineExtractorOptions options_;
  const ScanInRobot* scan_ = nullptr;
  std::vector<double> x_, y_, range2_, inverse_range2_, gap2_;
  std::vector<int> beam_;
  std::vector<LineSums> sums_;  ///< of all points before this one
};

}  // namespace marco::slam
