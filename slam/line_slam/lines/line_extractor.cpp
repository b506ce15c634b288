#include "slam/line_slam/lines/line_extractor.hpp"

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
  const std::size_t room = scan.beams.size();
  x_.resize(room);
  y_.resize(room);
  range2_.resize(room);
  inverse_range2_.resize(room);
  beam_.resize(room);
  sums_.resize(room + 1);
  Sums sums;
  std::size_t count = 0;
  for (std::size_t i = 0; i < room; ++i) {
    const Beam& beam = scan.beams[i];
    if (!beam.returned || beam.range_m > options_.max_range_m) continue;
    x_[count] = beam.hit_m.x();
    y_[count] = beam.hit_m.y();
    range2_[count] = square(beam.range_m);
    inverse_range2_[count] = 1.0 / range2_[count];
    beam_[count] = static_cast<int>(i);
    sums_[count] = sums;
    sums.add_point(beam.hit_m.x(), beam.hit_m.y(), 1.0);
    ++count;
  }
  sums_[count] = sums;
  x_.resize(count);
  y_.resize(count);
  gap2_.resize(count);
  for (std::size_t i = 0; i + 1 < count; ++i) {
    gap2_[i] = square(x_[i + 1] - x_[i]) + square(y_[i + 1] - y_[i]);
  }
  if (count > 0) gap2_.resize(count - 1);
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

double LineExtractor::squared_distance(int a, int b) const {
  const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
  return square(x_[j] - x_[i]) + square(y_[j] - y_[i]);
}

// Beams that went through the line and met something behind it: a door, not a stray. A single one
// may be an outlier.
bool LineExtractor::is_opening(int before, int after, const Line& line) const {
  if (after - before < 3 || squared_distance(before, after) <= square(options_.max_gap_m)) {
    return false;
  }
  const double side = line.across_of(scan_->sensor_m) > 0.0 ? 1.0 : -1.0;
  int through = 0;
  for (int i = before + 1; i < after; ++i) {
    const auto k = static_cast<std::size_t>(i);
    through += side * line.across_of(x_[k], y_[k]) < -options_.split_distance_m ? 1 : 0;
  }
  return through >= 2;
}

// From point to point of the line over the strays between them, few in a row.
bool LineExtractor::is_bridged(int before, int after, const Line& line) const {
  int last = before;
  for (int i = before + 1; i <= after; ++i) {
    if (i < after && !lie_on(i, i, line)) continue;
    const int strays = i - last - 1;
    if (strays > options_.max_outliers_in_a_row) return false;
    const double reach_m = options_.max_gap_m * (1.0 + strays);
    const bool wide = squared_distance(last, i) > square(reach_m);
    if (wide && (strays > 0 || is_gap_after(last))) return false;
    if (is_opening(last, i, line)) return false;
    last = i;
  }
  return true;
}

bool LineExtractor::fits_together(const Piece& before, const Piece& after) const {
  Sums sums = sums_of(before.core_first, before.core_last);
  sums.add(sums_of(after.first, after.last), 1.0);
  const Line line = line_of(sums);
  return line.rms_m <= options_.split_distance_m &&
         lie_on(before.core_first, before.core_last, line) &&
         lie_on(after.first, after.last, line) && is_bridged(before.last, after.first, line);
}

// A wall goes on in the next piece that fits, over pieces made of a stray and points of the wall.
void LineExtractor::merge() {
  merged_.clear();
  for (std::size_t i = 0; i < pieces_.size();) {
    if (pieces_[i].last - pieces_[i].first < 2) {
      ++i;
      continue;
    }
    Piece wall = pieces_[i++];
    for (std::size_t j = i; j < pieces_.size(); ++j) {
      const Piece& piece = pieces_[j];
      if (piece.first - wall.last > kLookAheadPoints) break;
      if (piece.last - piece.first < 2 || !fits_together(wall, piece)) continue;
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
