#include <algorithm>
#include <cmath>

#include "slam/line_slam/circles/circle_extractor.hpp"

namespace marco::slam {

// Bayesian information criteria, with the noise that the circle leaves where it is more than
// expected: what is right of two models does not hang on believing the laser's data sheet.
double CircleExtractor::advantage_of(const FittedCircle& circle, const Stretch& stretch) const {
  const auto sums_of = [this](int first, int last) {
    LineSums sums = line_sums_[static_cast<std::size_t>(last) + 1];
    sums.add(line_sums_[static_cast<std::size_t>(first)], -1.0);
    return sums;
  };
  const auto chi2_of_line = [&](int first, int last) {
    FittedLine line = fit_line(sums_of(first, last));
    double chi2 = 0.0;
    for (int round = 0; round < 2; ++round) {
      LineSums weighted;
      const Eigen::Vector2d normal(-line.along_y, line.along_x);
      for (int i = first; i <= last; ++i) {
        const bool edge = i == stretch.first || i == stretch.last;
        const double bearing_rad = edge ? spot_sigma_rad() : scan_->bearing_sigma_rad;
        const double head_on = square(normal.dot(point(i).at_m) / point(i).range_m);
        const double variance = square(sigma_m_) * head_on + square(kSurfaceSigmaM) +
                                square(bearing_rad * point(i).range_m) * (1.0 - head_on);
        weighted.add_point(point(i).at_m.x(), point(i).at_m.y(), 1.0 / variance);
      }
      line = fit_line(weighted);
      chi2 = square(line.rms_m) * weighted.weight;
    }
    return chi2;
  };
  const auto left = [&](int first, int last) {
    return square(fit_line(sums_of(first, last)).rms_m) * (last - first + 1);
  };
  const double one_line = chi2_of_line(stretch.first, stretch.last);
  int corner = -1;
  double least = 0.0;
  for (int i = stretch.first + 1; i + 2 <= stretch.last; ++i) {
    const double both = left(stretch.first, i) + left(i + 1, stretch.last);
    if (corner >= 0 && both >= least) continue;
    least = both;
    corner = i;
  }
  const double hits = stretch.size(), penalty = std::log(hits);
  const double noise = std::max(1.0, circle.chi2 / std::max(1.0, hits - 3.0));
  const double by_circle = (circle.chi2 + circle.bounds_chi2) / noise + 3.0 * penalty;
  double by_lines = one_line / noise + 2.0 * penalty;
  if (corner >= 0) {
    const double two_lines =
        chi2_of_line(stretch.first, corner) + chi2_of_line(corner + 1, stretch.last);
    by_lines = std::min(by_lines, two_lines / noise + 5.0 * penalty);
  }
  return by_lines - by_circle;
}

}  // namespace marco::slam
