#include "slam/line_slam/lines/split_and_merge.hpp"

#include <cmath>

namespace marco::slam {
namespace {

// How far behind a wall the merge looks for its next piece.
constexpr int kLookAheadPoints = 16;

}  // namespace

const std::vector<LinePiece>& SplitAndMerge::find(const ScanPoints& points) {
  cut_at_gaps(points);
  merge(points);
  return merged_;
}

void SplitAndMerge::cut_at_gaps(const ScanPoints& points) {
  pieces_.clear();
  int first = 0;
  for (int i = 0; i < points.size(); ++i) {
    if (i + 1 < points.size() && !points.is_gap_after(i)) continue;
    if (i > first) split(points, LinePiece::clean(first, i));
    first = i + 1;
  }
}

// Iterative end-point fit (4.1): the point farthest from the chord splits; left part first.
void SplitAndMerge::split(const ScanPoints& points, LinePiece chain) {
  stack_.clear();
  stack_.push_back(chain);
  while (!stack_.empty()) {
    const LinePiece piece = stack_.back();
    stack_.pop_back();
    const int corner = farthest_from_chord(points, piece);
    if (corner < 0) {
      pieces_.push_back(piece);
    } else {
      stack_.push_back(LinePiece::clean(corner, piece.last));
      stack_.push_back(LinePiece::clean(piece.first, corner));
    }
  }
}

int SplitAndMerge::farthest_from_chord(const ScanPoints& points, const LinePiece& piece) const {
  const double x0 = points.x(piece.first), y0 = points.y(piece.first);
  const double dx = points.x(piece.last) - x0, dy = points.y(piece.last) - y0;
  double farthest = 0.0;
  int corner = 0;
  for (int i = piece.first + 1; i < piece.last; ++i) {
    const double area = std::abs(dx * (points.y(i) - y0) - dy * (points.x(i) - x0));
    if (area > farthest) {
      farthest = area;
      corner = i;
    }
  }
  const double length2 = dx * dx + dy * dy;
  return square(farthest) > square(options_.split_distance_m) * length2 ? corner : -1;
}

// Whether the line leads from point to point over the outliers between them, few in a row.
bool SplitAndMerge::is_bridged(const ScanPoints& points,
                               int before,
                               int after,
                               const FittedLine& line) const {
  int last = before;
  for (int i = before + 1; i <= after; ++i) {
    if (i < after && !points.lie_on(i, i, line)) continue;
    const int outliers = i - last - 1;
    if (outliers > options_.max_outliers_in_a_row) return false;
    const double reach_m = options_.max_gap_m * (1.0 + outliers);
    const bool wide = points.squared_distance(last, i) > square(reach_m);
    if (wide && (outliers > 0 || points.is_gap_after(last))) return false;
    if (points.is_opening(last, i, line)) return false;
    last = i;
  }
  return true;
}

bool SplitAndMerge::fits_together(const ScanPoints& points,
                                  const LinePiece& before,
                                  const LinePiece& after) const {
  LineSums sums = points.sums_of(before.core_first, before.core_last);
  sums.add(points.sums_of(after.first, after.last), 1.0);
  const FittedLine line = fit_line(sums);
  return line.rms_m <= options_.split_distance_m &&
         points.lie_on(before.core_first, before.core_last, line) &&
         points.lie_on(after.first, after.last, line) &&
         is_bridged(points, before.last, after.first, line);
}

// A wall continues in the next piece that fits; pieces of an outlier and a wall point lie between.
void SplitAndMerge::merge(const ScanPoints& points) {
  merged_.clear();
  for (std::size_t i = 0; i < pieces_.size();) {
    if (pieces_[i].last - pieces_[i].first < 2) {
      ++i;
      continue;
    }
    LinePiece wall = pieces_[i++];
    for (std::size_t j = i; j < pieces_.size(); ++j) {
      const LinePiece& piece = pieces_[j];
      if (piece.first - wall.last > kLookAheadPoints) break;
      if (piece.last - piece.first < 2 || !fits_together(points, wall, piece)) continue;
      if (piece.first <= wall.last + 1 && wall.core_last == wall.last) {
        wall.core_last = piece.last;
      } else if (piece.last - piece.first > wall.core_last - wall.core_first) {
        wall.core_first = piece.first;
        wall.core_last = piece.last;
      }
      wall.last = piece.last;
      i = j + 1;
    }
    merged_.push_back(wall);
  }
}

}  // namespace marco::slam
