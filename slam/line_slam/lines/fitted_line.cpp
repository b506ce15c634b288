#include "slam/line_slam/lines/fitted_line.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {

void LineSums::add(const LineSums& other, double sign) {
  weight += sign * other.weight;
  x += sign * other.x;
  y += sign * other.y;
  xx += sign * other.xx;
  xy += sign * other.xy;
  yy += sign * other.yy;
}

void LineSums::add_point(double x_m, double y_m, double point_weight) {
  weight += point_weight;
  x += point_weight * x_m;
  y += point_weight * y_m;
  xx += point_weight * x_m * x_m;
  xy += point_weight * x_m * y_m;
  yy += point_weight * y_m * y_m;
}

double LineSums::regression_residual() const {
  const double rest_xx = xx - x * x / weight;
  const double rest_xy = xy - x * y / weight;
  return yy - y * y / weight - rest_xy * rest_xy / std::max(rest_xx, 1e-12);
}

double LineSums::regression_at(double x_m) const {
  const double slope = (xy - x * y / weight) / std::max(xx - x * x / weight, 1e-12);
  return y / weight + slope * (x_m - x / weight);
}

FittedLine fit_line(const LineSums& sums) {
  FittedLine line;
  line.center_x = sums.x / sums.weight;
  line.center_y = sums.y / sums.weight;
  const double xx = sums.xx - sums.x * line.center_x;
  const double xy = sums.xy - sums.x * line.center_y;
  const double yy = sums.yy - sums.y * line.center_y;
  const double half_difference = 0.5 * (xx - yy);
  const double radius = std::sqrt(square(half_difference) + square(xy));
  // The half angle without trigonometry, from whichever component is the larger.
  const double a = half_difference >= 0.0 ? radius + half_difference : std::abs(xy);
  const double b = half_difference >= 0.0 ? xy : std::copysign(radius - half_difference, xy);
  const double norm = std::sqrt(a * a + b * b);
  if (norm > 0.0) {
    line.along_x = a / norm;
    line.along_y = b / norm;
  }
  line.rms_m = std::sqrt(std::max(0.0, (0.5 * (xx + yy) - radius) / sums.weight));
  return line;
}

}  // namespace marco::slam
