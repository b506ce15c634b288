#include "plan/bulge.hpp"

#include <algorithm>
#include <cmath>

namespace marco::plan {

using Vector = Eigen::Vector2d;

double bulge_of(double turn_rad) { return std::tan(turn_rad / 4); }

BulgeArc bulge_arc(const Vector& from, const Vector& to, double bulge) {
  const Vector chord = to - from, left(-chord.y(), chord.x());
  BulgeArc arc;
  arc.turn_rad = 4 * std::atan(bulge);
  arc.centre = (from + to) / 2 + left * ((1 - bulge * bulge) / (4 * bulge));
  arc.radius = (from - arc.centre).norm();
  arc.from_rad = std::atan2(from.y() - arc.centre.y(), from.x() - arc.centre.x());
  return arc;
}

Vector BulgeArc::at(double part) const {
  const double angle = from_rad + part * turn_rad;
  return centre + radius * Vector(std::cos(angle), std::sin(angle));
}

double bulge_length_m(const Vector& from, const Vector& to, double bulge) {
  if (bulge == 0.0) return (to - from).norm();
  const BulgeArc arc = bulge_arc(from, to, bulge);
  return arc.radius * std::abs(arc.turn_rad);
}

double bulge_area_m2(const Vector& from, const Vector& to, double bulge) {
  if (bulge == 0.0) return 0.0;
  const BulgeArc arc = bulge_arc(from, to, bulge);
  return arc.radius * arc.radius / 2 * (arc.turn_rad - std::sin(arc.turn_rad));
}

std::vector<Vector> bulge_points(const Vector& from, const Vector& to, double bulge, double near) {
  if (bulge == 0.0) return {from};
  const BulgeArc arc = bulge_arc(from, to, bulge);
  const double step_rad = 2 * std::sqrt(2 * near / std::max(near, arc.radius));
  const int steps = std::max(2, static_cast<int>(std::ceil(std::abs(arc.turn_rad) / step_rad)));
  std::vector<Vector> points{from};
  for (int i = 1; i < steps; ++i) points.push_back(arc.at(static_cast<double>(i) / steps));
  return points;
}

}  // namespace marco::plan
