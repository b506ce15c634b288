#include "slam/line_slam/circles/circle_sums.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace marco::slam {

void CircleSums::add_point(const Eigen::Vector2d& point_m) {
  const Eigen::Vector3d row(point_m.x(), point_m.y(), 1.0);
  const double square = point_m.squaredNorm();
  count += 1.0;
  squares += row * row.transpose();
  with_square += square * row;
  fourth += square * square;
}

CircleSums CircleSums::operator-(const CircleSums& before) const {
  return {count - before.count, squares - before.squares, with_square - before.with_square,
          fourth - before.fourth};
}

RoughCircle fit_roughly(const CircleSums& sums) {
  // x^2 + y^2 = 2 a x + 2 b y + c, least squares.
  const Eigen::Vector3d found = sums.squares.inverse() * sums.with_square;
  RoughCircle circle;
  circle.centre_m = 0.5 * found.head<2>();
  circle.radius_m = std::sqrt(found.z() + circle.centre_m.squaredNorm());
  const double left = std::max(0.0, sums.fourth - found.dot(sums.with_square));
  circle.rms_m = std::sqrt(left / sums.count) / (2.0 * circle.radius_m);
  return circle;
}

}  // namespace marco::slam
