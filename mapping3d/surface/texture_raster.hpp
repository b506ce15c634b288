#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace marco::mapping3d {

/// Index of a pixel of a picture that is stored row by row.
inline std::size_t pixel_at(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(x);
}

/// Calls visit(x, y, weights) for each pixel whose centre lies in a triangle grown by `margin_px`.
/// The weights are barycentric; those of a pixel in the margin may be negative.
template <class Visit>
void for_each_pixel(const std::array<Eigen::Vector2f, 3>& p,
                    int width,
                    int height,
                    float margin_px,
                    const Visit& visit) {
  const auto cross = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const float area = cross(p[1] - p[0], p[2] - p[0]);
  if (std::abs(area) < 1e-9F) return;
  const Eigen::Vector2f low = p[0].cwiseMin(p[1]).cwiseMin(p[2]);
  const Eigen::Vector2f high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
  const auto first = [&](float value) {
    return std::max(0, static_cast<int>(std::ceil(std::max(-1.0F, value - margin_px))));
  };
  const auto last = [&](float value, int size) {
    return static_cast<int>(std::floor(std::min(static_cast<float>(size - 1), value + margin_px)));
  };
  std::array<float, 3> slack{};  // a margin in pixels as a share of each corner's height
  for (std::size_t i = 0; i < 3; ++i) {
    slack[i] = -margin_px * (p[(i + 1) % 3] - p[(i + 2) % 3]).norm() / std::abs(area);
  }
  for (int y = first(low.y()); y <= last(high.y(), height); ++y) {
    for (int x = first(low.x()); x <= last(high.x(), width); ++x) {
      const Eigen::Vector2f at(static_cast<float>(x), static_cast<float>(y));
      const float b = cross(at - p[0], p[2] - p[0]) / area;
      const float c = cross(p[1] - p[0], at - p[0]) / area;
      const Eigen::Vector3f weights(1.0F - b - c, b, c);
      if (weights[0] < slack[0] || weights[1] < slack[1] || weights[2] < slack[2]) continue;
      visit(x, y, weights);
    }
  }
}

}  // namespace marco::mapping3d
