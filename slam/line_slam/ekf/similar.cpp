#include "slam/line_slam/ekf/similar.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

// Rectangle and two half discs (fig. 5.2).
bool is_near(const Eigen::Vector2d& point_m, const Segment& segment, double distance_m) {
  const Eigen::Vector2d way = segment.end_m - segment.start_m;
  const double part =
      std::clamp((point_m - segment.start_m).dot(way) / way.squaredNorm(), 0.0, 1.0);
  return (point_m - segment.start_m - part * way).squaredNorm() <= distance_m * distance_m;
}

bool meets_position(const Segment& a, const Segment& b, const SimilarOptions& options) {
  const int inside = static_cast<int>(is_near(a.start_m, b, options.max_distance_m)) +
                     static_cast<int>(is_near(a.end_m, b, options.max_distance_m));
  if (inside != 1) return inside == 2;
  const double shorter_m = std::min((a.end_m - a.start_m).norm(), (b.end_m - b.start_m).norm());
  return overlap_m(a, b) >= std::min(options.min_overlap_m, 0.999 * shorter_m);
}

}  // namespace

double overlap_m(const Segment& a, const Segment& b) {
  const Eigen::Vector2d way = b.end_m - b.start_m;
  const double length_m = way.norm();
  const double s = (a.start_m - b.start_m).dot(way) / length_m;
  const double e = (a.end_m - b.start_m).dot(way) / length_m;
  return std::min(std::max(s, e), length_m) - std::max(std::min(s, e), 0.0);
}

bool similar(const Segment& a, const Segment& b, const SimilarOptions& options) {
  const Eigen::Vector2d u = a.end_m - a.start_m, v = b.end_m - b.start_m;
  if (u.squaredNorm() == 0.0 || v.squaredNorm() == 0.0) return false;
  const double angle_rad = std::abs(std::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v)));
  if (angle_rad >= options.max_angle_rad) return false;
  return meets_position(a, b, options) || meets_position(b, a, options);
}

}  // namespace marco::slam
