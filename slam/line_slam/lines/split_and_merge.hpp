#pragma once

#include <vector>

#include "slam/line_slam/lines/scan_points.hpp"

namespace marco::slam {

/// Points first..last in order. Merged pieces may have outliers between them, which do not lie on
/// the line; the core is the longest part without outliers.
struct LinePiece {
  int first = 0, last = 0;
  int core_first = 0, core_last = 0;
  static LinePiece clean(int first, int last) { return {first, last, first, last}; }
  bool has_outliers() const { return core_first != first || core_last != last; }
};

/// Split and merge (thesis A, 4.1 and 4.2; Douglas and Peucker 1973). What differs: the points are
/// cut at gaps first, so that no chord spans one, and the merge steps over a few outliers, so that
/// a wall with outliers on it is not lost (fig. 6.2).
class SplitAndMerge {
 public:
  explicit SplitAndMerge(const LineExtractorOptions& options) : options_(options) {}

  /// Pieces in order of bearing, valid until the next call.
  const std::vector<LinePiece>& find(const ScanPoints& points);

 private:
  void cut_at_gaps(const ScanPoints& points);
  void split(const ScanPoints& points, LinePiece chain);
  int farthest_from_chord(const ScanPoints& points, const LinePiece& piece) const;
  void merge(const ScanPoints& points);
  bool fits_together(const ScanPoints& points,
                     const LinePiece& before,
                     const LinePiece& after) const;
  bool is_bridged(const ScanPoints& points, int before, int after, const FittedLine& line) const;

  LineExtractorOptions options_;
  std::vector<LinePiece> pieces_, merged_, stack_;
};

}  // namespace marco::slam
