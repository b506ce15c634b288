#include "slam/lines/line_extractor.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {

LineExtractor::LineExtractor(const LineExtractorOptions& options) : options_(options) {
  validate(options, "line_extractor");
}

const std::vector<ObservedWall>& LineExtractor::extract(const ScanInRobot& scan) {
  scan_ = &scan;
  walls_.clear();
  take_points(scan);
  cut_at_gaps();
  merge();
  for (std::size_t i = 0; i < merged_.size(); ++i) accept(i);
  scan_ = nullptr;
  return walls_;
}

void LineExtractor::Sums::add(const Sums& other, double sign) {
  weight += sign * other.weight;
  x += sign * other.x;
  y += sign * other.y;
  xx += sign * other.xx;
  xy += sign * other.xy;
  yy += sign * other.yy;
}

void LineExtractor::Sums::add_point(double x_m, double y_m, double point_weight) {
  weight += point_weight;
  x += point_weight * x_m;
  y += point_weight * y_m;
  xx += point_weight * x_m * x_m;
  xy += point_weight * x_m * y_m;
  yy += point_weight * y_m * y_m;
}

void LineExtractor::take_points(const ScanInRobot& scan) {
  x_.clear();
  y_.clear();
  range2_.clear();
  beam_.clear();
  gap2_.clear();
  sums_.clear();
  Sums sums;
  for (std::size_t i = 0; i < scan.beams.size(); ++i) {
    const Beam& beam = scan.beams[i];
    if (!beam.returned || beam.range_m > options_.max_range_m) continue;
    x_.push_back(beam.hit_m.x());
    y_.push_back(beam.hit_m.y());
    range2_.push_back(square(beam.range_m));
    beam_.push_back(static_cast<int>(i));
    sums_.push_back(sums);
    sums.add_point(beam.hit_m.x(), beam.hit_m.y(), 1.0);
  }
  sums_.push_back(sums);
  for (std::size_t i = 0; i + 1 < x_.size(); ++i) {
    gap2_.push_back(square(x_[i + 1] - x_[i]) + square(y_[i + 1] - y_[i]));
  }
}

bool LineExtractor::is_gap_after(int point) const {
  const auto i = static_cast<std::size_t>(point);
  if (gap2_[i] <= square(options_.max_gap_m)) return false;
  if (gap2_[i] > square(options_.max_grazing_gap_m) || beam_[i + 1] - beam_[i] > 1) return true;
  // On a slanting wall neighbouring beams meet it far apart: then the gaps beside are wide too.
  if (i == 0 || i + 1 >= gap2_.size()) return true;
  return gap2_[i] > 4.0 * std::min(gap2_[i - 1], gap2_[i + 1]);
}

void LineExtractor::cut_at_gaps() {
  pieces_.clear();
  const int count = static_cast<int>(x_.size());
  int first = 0;
  for (int i = 0; i < count; ++i) {
    if (i + 1 < count && !is_gap_after(i)) continue;
    if (i > first) split(Piece::clean(first, i));
    first = i + 1;
  }
}

// Iterative end-point fit (ch. 4.1): the farthest point splits, the left part is looked at first.
void LineExtractor::split(Piece chain) {
  stack_.clear();
  stack_.push_back(chain);
  while (!stack_.empty()) {
    const Piece piece = stack_.back();
    stack_.pop_back();
    const int corner = farthest_from_chord(piece);
    if (corner < 0) {
      pieces_.push_back(piece);
    } else {
      stack_.push_back(Piece::clean(corner, piece.last));
      stack_.push_back(Piece::clean(piece.first, corner));
    }
  }
}

int LineExtractor::farthest_from_chord(const Piece& piece) const {
  const auto first = static_cast<std::size_t>(piece.first);
  const auto last = static_cast<std::size_t>(piece.last);
  const double x0 = x_[first], y0 = y_[first];
  const double dx = x_[last] - x0, dy = y_[last] - y0;
  const double length2 = dx * dx + dy * dy;
  double farthest = 0.0;
  std::size_t corner = 0;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double area = std::abs(dx * (y_[i] - y0) - dy * (x_[i] - x0));
    if (area > farthest) {
      farthest = area;
      corner = i;
    }
  }
  return square(farthest) > square(options_.split_distance_m) * length2 ? static_cast<int>(corner)
                                                                        : -1;
}

LineExtractor::Sums LineExtractor::sums_of(int first, int last) const {
  Sums sums = sums_[static_cast<std::size_t>(last) + 1];
  sums.add(sums_[static_cast<std::size_t>(first)], -1.0);
  return sums;
}

// Total least squares: the principal axis of the points.
LineExtractor::Line LineExtractor::line_of(const Sums& sums) {
  Line line;
  line.center_x = sums.x / sums.weight;
  line.center_y = sums.y / sums.weight;
  const double xx = sums.xx - sums.x * line.center_x;
  const double xy = sums.xy - sums.x * line.center_y;
  const double yy = sums.yy - sums.y * line.center_y;
  const double half_difference = 0.5 * (xx - yy);
  const double radius = std::sqrt(square(half_difference) + square(xy));
  // The half angle without trigonometry, from whichever component is the larger.
  const double a = half_difference >= 0.0 ? radius + half_difference : std::abs(xy);
  const double b = half_difference >= 0.0 ? xy : std::copysign(radius - half_difference, xy);
  const double norm = std::sqrt(a * a + b * b);
  if (norm > 0.0) {
    line.along_x = a / norm;
    line.along_y = b / norm;
  }
  line.rms_m = std::sqrt(std::max(0.0, (0.5 * (xx + yy) - radius) / sums.weight));
  return line;
}

bool LineExtractor::lie_on(int first, int last, const Line& line) const {
  for (int i = first; i <= last; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (std::abs(line.across_of(x_[k], y_[k])) > options_.split_distance_m) return false;
  }
  return true;
}

bool LineExtractor::fits_together(const Piece& before, const Piece& after) const {
  const auto last = static_cast<std::size_t>(before.last);
  const auto first = static_cast<std::size_t>(after.first);
  const int strays = std::max(0, after.first - before.last - 1);
  if (strays > options_.max_outliers_in_a_row) return false;
  const double reach_m = options_.max_gap_m * (1.0 + strays);
  const double gap2 = square(x_[first] - x_[last]) + square(y_[first] - y_[last]);
  if (gap2 > square(reach_m) && (strays > 0 || is_gap_after(before.last))) return false;
  Sums sums = sums_of(before.core_first, before.core_last);
  sums.add(sums_of(after.first, after.last), 1.0);
  const Line line = line_of(sums);
  return line.rms_m <= options_.split_distance_m &&
         lie_on(before.core_first, before.core_last, line) && lie_on(after.first, after.last, line);
}

void LineExtractor::merge() {
  merged_.clear();
  for (const Piece& piece : pieces_) {
    if (piece.last - piece.first < 2) continue;
    if (merged_.empty() || !fits_together(merged_.back(), piece)) {
      merged_.push_back(piece);
      continue;
    }
    Piece& wall = merged_.back();
    const bool touches = piece.first <= wall.last + 1 && wall.core_last == wall.last;
    if (touches) {
      wall.core_last = piece.last;
    } else if (piece.last - piece.first > wall.core_last - wall.core_first) {
      wall.core_first = piece.first;
      wall.core_last = piece.last;
    }
    wall.last = piece.last;
  }
}

}  // namespace marco::slam
