#include "slam/matching/oriented_points.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

// First and last index of the run around `at` that lies on one surface.
struct Run {
  Eigen::Index first;
  Eigen::Index last;
};

Run run_around(const Points2& points, Eigen::Index at, double gap_m, const NormalOptions& options) {
  Run run{at, at};
  const double radius2 = options.radius_m * options.radius_m;
  const double gap2 = gap_m * gap_m;
  const auto belongs = [&](Eigen::Index nearer, Eigen::Index next) {
    if ((points.col(next) - points.col(nearer)).squaredNorm() > gap2) return false;
    return nearer == at || (points.col(next) - points.col(at)).squaredNorm() <= radius2;
  };
  while (run.first > 0 && at - run.first < options.neighbours &&
         belongs(run.first, run.first - 1)) {
    --run.first;
  }
  while (run.last + 1 < points.cols() && run.last - at < options.neighbours &&
         belongs(run.last, run.last + 1)) {
    ++run.last;
  }
  return run;
}

}  // namespace

OrientedPoints orient(const Points2& points,
                      const Eigen::Vector2d& sensor,
                      const NormalOptions& options) {
  validate(options, "normals");
  OrientedPoints oriented{points, Points2::Zero(2, points.cols())};
  for (Eigen::Index at = 0; at < points.cols(); ++at) {
    const double range_m = (points.col(at) - sensor).norm();
    const double gap_m = std::max(options.gap_m, options.gap_per_range * range_m);
    const Run run = run_around(points, at, gap_m, options);
    const Eigen::Index count = run.last - run.first + 1;
    if (count < 3) continue;
    const auto neighbours = points.middleCols(run.first, count);
    const Eigen::Vector2d mean = neighbours.rowwise().mean();
    double xx = 0, xy = 0, yy = 0;
    for (Eigen::Index i = run.first; i <= run.last; ++i) {
      const Eigen::Vector2d d = points.col(i) - mean;
      xx += d.x() * d.x();
      xy += d.x() * d.y();
      yy += d.y() * d.y();
    }
    const double half_difference = 0.5 * (xx - yy);
    const double root = std::hypot(half_difference, xy);
    const double smallest = std::max(0.0, 0.5 * (xx + yy) - root);
    if (smallest > options.max_rms_m * options.max_rms_m * static_cast<double>(count)) continue;
    if (root <= 0.0) continue;
    const double direction = 0.5 * std::atan2(2.0 * xy, xx - yy);
    Eigen::Vector2d normal(-std::sin(direction), std::cos(direction));
    if (normal.dot(sensor - points.col(at)) < 0.0) normal = -normal;
    oriented.normals.col(at) = normal;
  }
  return oriented;
}

}  // namespace marco::slam
