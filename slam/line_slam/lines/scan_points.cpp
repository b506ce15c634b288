#include "slam/line_slam/lines/scan_points.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {

void ScanPoints::take(const ScanInRobot& scan) {
  scan_ = &scan;
  const std::size_t room = scan.beams.size();
  for (auto* values : {&x_, &y_, &range2_, &inverse_range2_}) values->resize(room);
  beam_.resize(room);
  sums_.resize(room + 1);
  LineSums sums;
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
  gap2_.resize(count > 0 ? count - 1 : 0);
  for (int i = 0; i + 1 < size(); ++i) gap2_[at(i)] = squared_distance(i, i + 1);
}

LineSums ScanPoints::sums_of(int first, int last) const {
  LineSums sums = sums_[at(last) + 1];
  sums.add(sums_[at(first)], -1.0);
  return sums;
}

bool ScanPoints::lie_on(int first, int last, const FittedLine& line) const {
  for (int i = first; i <= last; ++i) {
    if (std::abs(across_of(line, i)) > options_.split_distance_m) return false;
  }
  return true;
}

bool ScanPoints::is_gap_after(int point) const {
  const std::size_t i = at(point);
  if (gap2_[i] <= square(options_.max_gap_m)) return false;
  if (gap2_[i] > square(options_.max_grazing_gap_m) || beam_[i + 1] - beam_[i] > 1) return true;
  // Beams that graze a wall hit it far apart: then the gaps on both sides are wide too.
  if (i == 0 || i + 1 >= gap2_.size()) return true;
  return gap2_[i] > 4.0 * std::min(gap2_[i - 1], gap2_[i + 1]);
}

bool ScanPoints::is_opening(int before, int after, const FittedLine& line) const {
  if (after - before < 3 || squared_distance(before, after) <= square(options_.max_gap_m)) {
    return false;
  }
  const double side = line.across_of(scan_->sensor_m) > 0.0 ? 1.0 : -1.0;
  int through = 0;
  for (int i = before + 1; i < after; ++i) {
    through += side * across_of(line, i) < -options_.split_distance_m ? 1 : 0;
  }
  return through >= 2;
}

}  // namespace marco::slam
