#include "common/simplify_polyline.hpp"

#include <cmath>

namespace marco {
namespace {

using Eigen::Vector2d;

double distance_to_line(const Vector2d& point, const Vector2d& from, const Vector2d& to) {
  const Vector2d along = to - from;
  if (along.norm() < 1e-9) return (point - from).norm();
  return std::abs(along.x() * (point - from).y() - along.y() * (point - from).x()) / along.norm();
}

// Takes what lies between two points that are kept.
void keep_far_points(std::span<const Vector2d> points,
                     double tolerance,
                     std::size_t first,
                     std::size_t last,
                     std::vector<Vector2d>& kept) {
  std::size_t farthest = first;
  double distance = tolerance;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double found = distance_to_line(points[i], points[first], points[last]);
    if (found <= distance) continue;
    distance = found;
    farthest = i;
  }
  if (farthest == first) return;
  keep_far_points(points, tolerance, first, farthest, kept);
  kept.push_back(points[farthest]);
  keep_far_points(points, tolerance, farthest, last, kept);
}

}  // namespace

std::vector<Vector2d> simplify_polyline(std::span<const Vector2d> points, double tolerance) {
  if (points.empty()) return {};
  std::vector<Vector2d> kept{points.front()};
  keep_far_points(points, tolerance, 0, points.size() - 1, kept);
  if (points.size() > 1) kept.push_back(points.back());
  return kept;
}

}  // namespace marco
