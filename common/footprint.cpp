#include "common/footprint.hpp"

#include <algorithm>
#include <limits>

#include "lcm_tools/base/check.hpp"

namespace marco {
namespace {

constexpr double kFarthestCornerM = 20.0;  // of any robot; beyond is a wrong unit
constexpr std::size_t kMostCorners = 64;
// A point that was within the margin at the start may come nearer by so much, for the swing of a
// corner, but not up to the body.
constexpr double kNearerM = 1e-4, kNearestM = 0.01, kRoundingM = 1e-6;

double least_distance_m(double at_start_m, double margin_m) {
  return std::min(margin_m,
                  std::max(at_start_m - kNearerM, std::min(at_start_m, kNearestM) - kRoundingM));
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double squared_to_edge(const Eigen::Vector2d& p,
                       const Eigen::Vector2d& a,
                       const Eigen::Vector2d& b) {
  const Eigen::Vector2d edge = b - a, to_p = p - a;
  const double part = std::clamp(to_p.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
  return (to_p - part * edge).squaredNorm();
}

bool edges_touch(const Eigen::Vector2d& a,
                 const Eigen::Vector2d& b,
                 const Eigen::Vector2d& c,
                 const Eigen::Vector2d& d) {
  const double of_c = cross(b - a, c - a), of_d = cross(b - a, d - a);
  const double of_a = cross(d - c, a - c), of_b = cross(d - c, b - c);
  if (of_c * of_d < 0.0 && of_a * of_b < 0.0) return true;
  return std::min({squared_to_edge(a, c, d), squared_to_edge(b, c, d), squared_to_edge(c, a, b),
                   squared_to_edge(d, a, b)}) == 0.0;
}

bool is_simple(const std::vector<Eigen::Vector2d>& corners) {
  const std::size_t n = corners.size();
  double area = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % n], &c = corners[(i + 2) % n];
    area += cross(a, b) / 2.0;
    if (a == b || (cross(b - a, c - b) == 0.0 && (b - a).dot(c - b) < 0.0)) return false;
    for (std::size_t j = i + 2; j < n && j + 1 < n + i; ++j) {
      if (edges_touch(a, b, corners[j], corners[(j + 1) % n])) return false;
    }
  }
  return std::abs(area) > 1e-6;
}

}  // namespace

Footprint::Footprint(const std::vector<double>& corners_m) {
  require(
      corners_m.size() % 2 == 0 && corners_m.size() >= 6 && corners_m.size() <= 2 * kMostCorners,
      "body_m takes x and y of 3 to 64 corners [m]: x1, y1, x2, y2, ...");
  for (std::size_t i = 0; i < corners_m.size(); i += 2) {
    const Eigen::Vector2d corner(corners_m[i], corners_m[i + 1]);
    require(corner.norm() <= kFarthestCornerM, "body_m: a corner is more than 20 m away");
    corners_m_.push_back(corner);
    radius_m_ = std::max(radius_m_, corner.norm());
    front_m_ = std::max(front_m_, corner.x());
    back_m_ = std::max(back_m_, -corner.x());
    half_width_m_ = std::max(half_width_m_, std::abs(corner.y()));
  }
  require(is_simple(corners_m_),
          "body_m is not an outline: its edges touch each other, or enclose no area");
}

std::vector<double> Footprint::box(double front_m, double back_m, double half_width_m) {
  return {front_m, -half_width_m, front_m, half_width_m,
          -back_m, half_width_m,  -back_m, -half_width_m};
}

double Footprint::distance_m(const Eigen::Vector2d& point) const {
  double squared = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (std::size_t i = 0, before = corners_m_.size() - 1; i < corners_m_.size(); before = i++) {
    const Eigen::Vector2d &a = corners_m_[before], &b = corners_m_[i];
    squared = std::min(squared, squared_to_edge(point, a, b));
    if ((a.y() > point.y()) != (b.y() > point.y())) {
      const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      if (point.x() < x) inside = !inside;
    }
  }
  return inside ? -std::sqrt(squared) : std::sqrt(squared);
}

void advance(Sweep& sweep, const Pose2& moved, double radius_m) {
  if (sweep.empty()) sweep.emplace_back();
  const SweptPose& last = sweep.back();
  const double swept_m = moved.translation_m().norm() + std::abs(moved.theta_rad) * radius_m;
  sweep.push_back({last.start_from_robot * moved, last.swept_m + swept_m});
}

std::size_t first_contact(const Footprint& body,
                          std::span<const SweptPose> sweep,
                          std::span<const Eigen::Vector2d> points,
                          double margin_m) {
  std::size_t first = sweep.size();
  if (sweep.empty()) return first;
  const double reach_m = body.radius_m() + margin_m + sweep.back().swept_m;
  std::vector<Pose2> robot_from_start;
  for (const SweptPose& pose : sweep) robot_from_start.push_back(pose.start_from_robot.inverse());
  for (const Eigen::Vector2d& point : points) {
    if (point.squaredNorm() > reach_m * reach_m) continue;
    const double at_start_m = body.distance_m(robot_from_start[0] * point);
    const double least_m = least_distance_m(at_start_m, margin_m);
    double distance_m = at_start_m;
    for (std::size_t i = 0; i < first;) {
      const double safe_m = sweep[i].swept_m + (distance_m - least_m);
      do ++i;
      while (i < first && sweep[i].swept_m <= safe_m);
      if (i >= first) break;
      distance_m = body.distance_m(robot_from_start[i] * point);
      if (distance_m < least_m) first = i;
    }
  }
  return first;
}

}  // namespace marco
