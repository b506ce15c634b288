#include "mapping3d/clouds/scan_lines.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "common/median.hpp"

namespace marco::mapping3d {
namespace {

// Of fewer the widest gaps of angles that lie anywhere differ too much; lasers have 8 rings or
// more.
constexpr std::size_t kFewestLines = 8;
constexpr std::size_t kFewestOfLine = 4;  // angles, in the mean
// How much wider a gap between lines is than any within one. Of angles that lie anywhere, the
// eighth widest gap is by a seventh wider than the ninth, in the mean.
constexpr double kLeastStep = 4.0;
// Sectors in which nothing was seen step, too, before the lines, and stray angles after them.
constexpr double kOfWidestStep = 0.25;
constexpr double kStrayPart = 0.1;  // of the angles of a line; fewer are no line
// Narrower gaps are rounding errors of coordinates.
constexpr double kLeastGapRad = 2e-5;

// Means of the angles between gaps of at least so much.
std::vector<double> lines_apart_by(double least_gap_rad, const std::vector<double>& sorted_rad) {
  struct Line {
    double sum_rad = 0.0;
    std::size_t count = 0;
  };
  std::vector<Line> lines(1);
  for (std::size_t i = 0; i < sorted_rad.size(); ++i) {
    if (i > 0 && sorted_rad[i] - sorted_rad[i - 1] >= least_gap_rad) lines.emplace_back();
    lines.back().sum_rad += sorted_rad[i];
    ++lines.back().count;
  }
  std::vector<double> found_rad;
  const auto fewest =
      kStrayPart * static_cast<double>(sorted_rad.size()) / static_cast<double>(lines.size());
  for (const Line& line : lines) {
    const auto count = static_cast<double>(line.count);
    if (count >= fewest) found_rad.push_back(line.sum_rad / count);
  }
  return found_rad;
}

}  // namespace

ScanLines::ScanLines(double first_rad, double step_rad, std::size_t count)
    : first_rad_(first_rad), step_rad_(step_rad), count_(count) {}

ScanLines::ScanLines(std::vector<double> lines_rad)
    : step_rad_(0.0), count_(lines_rad.size()), lines_rad_(std::move(lines_rad)) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < count_; ++i) steps.push_back(lines_rad_[i] - lines_rad_[i - 1]);
  step_rad_ = median(std::move(steps));
}

std::size_t ScanLines::at(double angle_rad) const {
  if (lines_rad_.empty()) {
    const double line = std::round((angle_rad - first_rad_) / step_rad_);
    return static_cast<std::size_t>(std::clamp(line, 0.0, static_cast<double>(count_ - 1)));
  }
  const auto after = std::lower_bound(lines_rad_.begin(), lines_rad_.end(), angle_rad);
  if (after == lines_rad_.begin()) return 0;
  if (after == lines_rad_.end()) return count_ - 1;
  const bool is_before = angle_rad - *(after - 1) < *after - angle_rad;
  return static_cast<std::size_t>(after - lines_rad_.begin()) - (is_before ? 1 : 0);
}

double ScanLines::angle_rad(std::size_t line) const {
  return lines_rad_.empty() ? first_rad_ + step_rad_ * static_cast<double>(line) : lines_rad_[line];
}

std::vector<double> find_lines(std::vector<double> angles_rad) {
  const std::size_t most_lines = angles_rad.size() / kFewestOfLine;
  if (most_lines < kFewestLines) return {};
  std::sort(angles_rad.begin(), angles_rad.end());
  std::vector<double> gaps;
  for (std::size_t i = 1; i < angles_rad.size(); ++i) {
    gaps.push_back(angles_rad[i] - angles_rad[i - 1]);
  }
  std::vector<double> widest = gaps;
  const auto end = widest.begin() + static_cast<std::ptrdiff_t>(most_lines);
  std::partial_sort(widest.begin(), end, widest.end(), std::greater<>());
  // `count` lines have one gap fewer.
  const auto step = [&widest](std::size_t count) {
    return std::max(widest[count - 2], kLeastGapRad) / std::max(widest[count - 1], kLeastGapRad);
  };
  double widest_step = 0.0;
  for (std::size_t count = kFewestLines; count < most_lines; ++count) {
    widest_step = std::max(widest_step, step(count));
  }
  const double least = std::max(kLeastStep, kOfWidestStep * widest_step);
  std::size_t lines = 0;
  for (std::size_t count = kFewestLines; count < most_lines; ++count) {
    if (step(count) > least) lines = count;
  }
  if (lines == 0) return {};
  return lines_apart_by(widest[lines - 2], angles_rad);
}

std::vector<double> complete_lines(const std::vector<double>& lines_rad,
                                   const std::vector<double>& all_angles_rad) {
  if (lines_rad.size() < 2 || all_angles_rad.empty()) return lines_rad;
  const double step_rad = ScanLines(lines_rad).step_rad();
  const auto [least, most] = std::minmax_element(all_angles_rad.begin(), all_angles_rad.end());
  std::vector<double> filled_rad;
  const double before = std::round((lines_rad.front() - *least) / step_rad);
  for (double k = before; k >= 0.0; --k) filled_rad.push_back(lines_rad.front() - k * step_rad);
  for (std::size_t i = 1; i < lines_rad.size(); ++i) {
    const double gap_rad = lines_rad[i] - lines_rad[i - 1];
    const double steps = std::round(gap_rad / step_rad);
    for (double k = 1.0; k < steps; ++k)
      filled_rad.push_back(lines_rad[i - 1] + k * gap_rad / steps);
    filled_rad.push_back(lines_rad[i]);
  }
  const double after = std::round((*most - lines_rad.back()) / step_rad);
  for (double k = 1.0; k <= after; ++k) filled_rad.push_back(lines_rad.back() + k * step_rad);
  const ScanLines lines(filled_rad);
  std::vector<std::size_t> counts(filled_rad.size(), 0);
  for (const double angle_rad : all_angles_rad) ++counts[lines.at(angle_rad)];
  const double fewest = kStrayPart * static_cast<double>(all_angles_rad.size()) /
                        static_cast<double>(filled_rad.size());
  std::vector<double> used_rad;
  for (std::size_t i = 0; i < filled_rad.size(); ++i) {
    if (static_cast<double>(counts[i]) >= fewest) used_rad.push_back(filled_rad[i]);
  }
  return used_rad;
}

}  // namespace marco::mapping3d
