#include "slam/matching/oriented_points.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

// Second moments of a run of points about its first taken point.
struct Moments {
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  int count = 1;

  void add(double dx, double dy) {
    x += dx;
    y += dy;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
    ++count;
  }
};

// Unit vector along the smallest principal component; zero if undefined or too large.
Eigen::Vector2d normal_of(const Moments& m, double max_rms_m) {
  const double n = m.count;
  const double xx = m.xx - m.x * m.x / n, xy = m.xy - m.x * m.y / n, yy = m.yy - m.y * m.y / n;
  const double half_difference = 0.5 * (xx - yy);
  const double root = std::sqrt(half_difference * half_difference + xy * xy);
  const double smallest = 0.5 * (xx + yy) - root;
  if (smallest > max_rms_m * max_rms_m * n || root <= 0.0) return Eigen::Vector2d::Zero();
  // The line's direction has cos 2a = half_difference / root, sin 2a = xy / root; the larger one of
  // cos a and sin a from the half-angle formula.
  const double larger = std::sqrt(0.5 * (1.0 + std::abs(half_difference) / root));
  const double smaller = 0.5 * xy / (root * larger);
  return half_difference >= 0.0 ? Eigen::Vector2d(-smaller, larger)
                                : Eigen::Vector2d(-larger, smaller);
}

// Sizes that grow with the noise of the ranges, in its standard deviations: a neighbourhood of 20
// leaves a normal's direction within some degrees.
constexpr double kRadiusSigmas = 20.0, kRmsSigmas = 2.4;

NormalOptions adapted(NormalOptions options, double range_sigma_m) {
  const double growth = std::max(1.0, kRadiusSigmas * range_sigma_m / options.radius_m);
  options.radius_m *= growth;
  options.neighbours = static_cast<int>(std::lround(options.neighbours * growth));
  options.max_rms_m = std::max(options.max_rms_m, kRmsSigmas * range_sigma_m);
  return options;
}

}  // namespace

OrientedPoints orient(const Points2& points,
                      const Eigen::Vector2d& sensor,
                      const NormalOptions& where_precise,
                      double range_sigma_m) {
  validate(where_precise, "normals");
  const NormalOptions options = adapted(where_precise, range_sigma_m);
  const Eigen::Index count = points.cols();
  OrientedPoints oriented{points, Points2::Zero(2, count), range_sigma_m};
  const double radius2 = options.radius_m * options.radius_m;
  for (Eigen::Index at = 0; at < count; ++at) {
    const double x = points(0, at), y = points(1, at);
    const Eigen::Vector2d to_sensor(sensor.x() - x, sensor.y() - y);
    const double gap2 =
        std::max(options.gap_m * options.gap_m,
                 options.gap_per_range * options.gap_per_range * to_sensor.squaredNorm());
    Moments moments;
    const Eigen::Index first = std::max<Eigen::Index>(0, at - options.neighbours);
    const Eigen::Index last = std::min<Eigen::Index>(count - 1, at + options.neighbours);
    // Outliers between the points of a wall are skipped.
    bool is_first = true;
    const auto take = [&](Eigen::Index next) {
      const double dx = points(0, next) - x, dy = points(1, next) - y;
      const double d2 = dx * dx + dy * dy;
      if (d2 > radius2 && (!is_first || d2 > gap2)) return;
      moments.add(dx, dy);
      is_first = false;
    };
    for (Eigen::Index i = at - 1; i >= first; --i) take(i);
    is_first = true;
    for (Eigen::Index i = at + 1; i <= last; ++i) take(i);
    if (moments.count < 3) continue;
    const Eigen::Vector2d normal = normal_of(moments, options.max_rms_m);
    oriented.normals.col(at) = normal.dot(to_sensor) < 0.0 ? Eigen::Vector2d(-normal) : normal;
  }
  return oriented;
}

}  // namespace marco::slam
