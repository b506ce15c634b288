#include "slam/matching/calculated_points.hpp"

#include <algorithm>

namespace marco::slam {
namespace {

// Largest width over length of points that have a direction.
constexpr double kStraight = 0.1;

}  // namespace

CalculatedPoints::CalculatedPoints(const Points2& points, CalculatedPointsOptions options)
    : options_(options),
      points_(points),
      lines_(points.cols()),
      good_(points.cols(), 0),
      courses_(points.cols()),
      straight_(points.cols(), 0),
      embedded_(points.cols(), 0) {
  validate(options_, "calculated_points");
  if (points_.cols() < 3) return;
  for (int i = 0; i < points_.cols(); ++i) {
    grow(i);
    follow(i);
  }
}

void CalculatedPoints::grow(int index) {
  const auto point = [this](int i) { return points_.col(i); };
  const int middle = std::clamp(index, 1, static_cast<int>(points_.cols()) - 2);
  LineSums sums;
  for (int i = middle - 1; i <= middle + 1; ++i) sums.add(point(i));
  Line line = sums.line();
  if ((point(middle - 1) - point(middle)).norm() > options_.max_gap_m) return;
  if ((point(middle + 1) - point(middle)).norm() > options_.max_gap_m) return;
  const auto try_neighbour = [&](int i) {
    if (i < 0 || i >= points_.cols() || line.distance_m(point(i)) > options_.near_line_m) return;
    sums.add(point(i));
    const Line grown = sums.line();
    if (grown.rms_m > line.rms_m + options_.error_growth_m) {
      sums.remove(point(i));
    } else {
      line = grown;
    }
  };
  for (int k = 2; k < 2 + options_.max_neighbours / 2; ++k) {
    try_neighbour(middle - k);
    try_neighbour(middle + k);
  }
  embedded_[index] = 1;
  lines_[index] = line;
  good_[index] = line.rms_m <= options_.good_fit_m;
}

void CalculatedPoints::follow(int index) {
  const int last = static_cast<int>(points_.cols()) - 1;
  const int middle = std::clamp(index, 1, last - 1);
  int low = middle - 1, high = middle + 1;
  const auto near = [&](int i) {
    return (points_.col(i) - points_.col(middle)).squaredNorm() <=
           options_.course_m * options_.course_m;
  };
  while (low > 0 && near(low - 1)) --low;
  while (high < last && near(high + 1)) ++high;
  LineSums sums;
  for (int i = low; i <= high; ++i) sums.add(points_.col(i));
  courses_[index] = sums.line();
  const double length_m = (points_.col(high) - points_.col(low)).norm();
  straight_[index] = courses_[index].rms_m <= std::max(options_.good_fit_m, kStraight * length_m);
}

CalculatedPoints::Partner CalculatedPoints::partner(const Eigen::Vector2d& query,
                                                    int nearest) const {
  const Eigen::Vector2d raw = points_.col(nearest);
  const Line* near = line(nearest);
  if (near == nullptr) return {raw, nullptr};
  const Eigen::Vector2d projected = near->project(query);
  if ((projected - query).squaredNorm() > (raw - query).squaredNorm()) return {raw, nullptr};
  return {projected, near};
}

}  // namespace marco::slam
