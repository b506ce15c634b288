#pragma once

#include <Eigen/Geometry>

namespace marco {

/// Squared distance to a triangle (Ericson, Real-Time Collision Detection, 5.1.5); of one without
/// area it may be no number. In double: in float a sliver of 5 m x 5 mm is off by decimetres.
inline float squared_distance(const Eigen::Vector3f& point,
                              const Eigen::Vector3f& first,
                              const Eigen::Vector3f& second,
                              const Eigen::Vector3f& third) {
  const Eigen::Vector3d p = point.cast<double>(), a = first.cast<double>();
  const Eigen::Vector3d b = second.cast<double>(), c = third.cast<double>();
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const auto square = [](const Eigen::Vector3d& of) {
    return static_cast<float>(of.squaredNorm());
  };
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp);
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return square(ap);
  if (d3 >= 0 && d4 <= d3) return square(bp);
  if (d6 >= 0 && d5 <= d6) return square(cp);
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return square(ap - d1 / (d1 - d3) * ab);
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return square(ap - d2 / (d2 - d6) * ac);
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    return square(bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b));
  }
  const double scale = 1.0 / (va + vb + vc);
  return square(ap - ab * (vb * scale) - ac * (vc * scale));
}

}  // namespace marco
