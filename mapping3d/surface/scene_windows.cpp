#include "mapping3d/surface/scene_windows.hpp"

#include <algorithm>
#include <cmath>

#include "common/median.hpp"

namespace marco::mapping3d {

SceneWindows::SceneWindows(const ScenePoints& scene) : scene_(scene) {
  for (const Eigen::Vector3f& origin : scene.origins_m) centre_m_ += origin.cast<double>();
  if (!scene.origins_m.empty()) centre_m_ /= static_cast<double>(scene.origins_m.size());
  find_beams();
  add_up();
}

void SceneWindows::find_beams() {
  ranges_m_.assign(scene_.points_m.size(), 0.0);
  beams_.assign(scene_.points_m.size(), Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    const double range_m = (scene_.points_m[i].cast<double>() - centre_m_).norm();
    if (scene_.valid[i] == 0 || !(range_m > 1e-3)) continue;
    ranges_m_[i] = range_m;
    beams_[i] = (scene_.points_m[i] - scene_.origins_m[i / scene_.columns]).normalized();
  }
  spacing_rad_ = std::sqrt(median_step(scene_.columns) * median_step(1));
}

// Between neighbours in a row (stride 1) or in a column.
float SceneWindows::median_step(std::size_t stride) const {
  std::vector<float> steps_rad;
  for (std::size_t i = 0; i + stride < beams_.size(); ++i) {
    if (ranges_m_[i] <= 0.0 || ranges_m_[i + stride] <= 0.0) continue;
    if (stride == 1 && (i + 1) % scene_.columns == 0) continue;
    steps_rad.push_back((beams_[i + stride] - beams_[i]).norm());
  }
  return median(std::move(steps_rad));
}

void SceneWindows::add_up() {
  const std::size_t width = scene_.columns + 1;
  sums_.assign((scene_.rows + 1) * width, Sums{});
  for (std::size_t row = 0; row < scene_.rows; ++row) {
    Sums line{};
    for (std::size_t column = 0; column < scene_.columns; ++column) {
      const std::size_t index = scene_.index(row, column);
      if (ranges_m_[index] > 0.0) {
        const double inverse = 1.0 / ranges_m_[index], square = inverse * inverse;
        const Eigen::Vector3d q = inverse * (scene_.points_m[index].cast<double>() - centre_m_);
        const Sums own{q.x() * q.x(),   q.x() * q.y(), q.x() * q.z(),   q.y() * q.y(),
                       q.y() * q.z(),   q.z() * q.z(), q.x() * inverse, q.y() * inverse,
                       q.z() * inverse, square,        square * square, 1.0};
        for (std::size_t i = 0; i < kSums; ++i) line[i] += own[i];
      }
      const Sums& above = sums_[row * width + column + 1];
      Sums& here = sums_[(row + 1) * width + column + 1];
      for (std::size_t i = 0; i < kSums; ++i) here[i] = above[i] + line[i];
    }
  }
}

// From a beam to the last neighbour, on either side, that lies within an angle.
int SceneWindows::steps_within(
    std::size_t index, int at, int end, std::size_t stride, float angle_rad) const {
  const auto beyond = [&](std::size_t other) {
    return ranges_m_[other] > 0.0 &&
           (beams_[other] - beams_[index]).squaredNorm() > angle_rad * angle_rad;
  };
  const int most = std::max(1, (end - 1) / 2);
  int steps = 1;
  for (; steps < most; ++steps) {
    const std::size_t next = static_cast<std::size_t>(steps + 1) * stride;
    if (at > steps && beyond(index - next)) break;
    if (at + steps + 1 < end && beyond(index + next)) break;
  }
  return steps;
}

WindowReach SceneWindows::reach(int row, int column, int half) const {
  const float angle_rad = (static_cast<float>(half) + 0.5F) * spacing_rad_;
  const std::size_t index = at(row, column);
  return {steps_within(index, row, rows(), scene_.columns, angle_rad),
          steps_within(index, column, columns(), 1, angle_rad)};
}

WindowPlane SceneWindows::fit(int row, int column, const WindowReach& reach) const {
  const int top = std::max(0, row - reach.rows), bottom = std::min(rows(), row + reach.rows + 1);
  const int left = std::max(0, column - reach.columns);
  const int right = std::min(columns(), column + reach.columns + 1);
  const Sums &a = sums_at(top, left), &b = sums_at(top, right), &c = sums_at(bottom, left),
             &d = sums_at(bottom, right);
  Sums s;
  for (std::size_t i = 0; i < kSums; ++i) s[i] = d[i] - b[i] - c[i] + a[i];
  WindowPlane plane;
  const double count = s[11];
  if (count < 0.6 * (2 * reach.rows + 1) * (2 * reach.columns + 1)) return plane;
  // Cramer's rule on the symmetric matrix of q qT.
  const double c00 = s[3] * s[5] - s[4] * s[4], c01 = s[2] * s[4] - s[1] * s[5];
  const double c02 = s[1] * s[4] - s[2] * s[3], c11 = s[0] * s[5] - s[2] * s[2];
  const double c12 = s[1] * s[2] - s[0] * s[4], c22 = s[0] * s[3] - s[1] * s[1];
  const double determinant = s[0] * c00 + s[1] * c01 + s[2] * c02;
  if (!(determinant > 1e-12)) return plane;
  plane.covariance << c00, c01, c02, c01, c11, c12, c02, c12, c22;
  plane.covariance /= determinant;
  plane.m = plane.covariance * Eigen::Vector3d(s[6], s[7], s[8]);
  const double fitted = plane.m.x() * s[6] + plane.m.y() * s[7] + plane.m.z() * s[8];
  plane.residual = std::sqrt(std::max(0.0, s[9] - fitted) / (count - 3.0));
  plane.by_range = s[10] / count;
  plane.by_direction = std::max(0.0, plane.m.squaredNorm() - fitted / count);
  return plane;
}

}  // namespace marco::mapping3d
