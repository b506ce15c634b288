#include "slam/line_slam/circles/circle_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "common/linear_algebra.hpp"

namespace marco::slam {
namespace {

constexpr int kMostIterations = 30;   // against hanging
constexpr double kConvergedM = 1e-6;  // far below any noise
// A little beyond the radii that are taken (kLeastRadiusM, kLargestRadiusM): at a bound a fit would
// stay, and pass for one.
constexpr double kLeastFittedM = 0.005, kLargestFittedM = 20.0;
// Half chord of a ray, in radii, below which its range is taken as linear: at the tangent the range
// has no derivative.
constexpr double kLeastHalfChord = 0.2;
// How sharply a ray that passes beside bounds the circle: edges of beams are as wide as this.
constexpr double kEdgeSigmaM = 0.003;

struct Sums : NormalEquations<3> {
  double cost = 0.0;  // of all
  double chi2 = 0.0;  // of hits
  int hits = 0;
};

double left_distance(const CircleRay& ray, const Eigen::Vector2d& centre_m) {
  const Eigen::Vector2d to = centre_m - ray.origin_m;
  return ray.direction.x() * to.y() - ray.direction.y() * to.x();
}

struct Prediction {
  double range_m;
  double slope;  // of the range, per distance across
  double half_chord_m;
  double side;  // -1: the ray enters there, 1: it leaves there
};

Prediction predict(const CircleRay& ray, const FittedCircle& circle) {
  const double radius_m = circle.radius_m;
  const double along_m = ray.direction.dot(circle.centre_m - ray.origin_m);
  const double across_m = left_distance(ray, circle.centre_m);
  const double least_m = kLeastHalfChord * radius_m;
  const double inside = radius_m * radius_m - across_m * across_m;
  const double side = circle.from_inside ? 1.0 : -1.0;
  const double half_chord_m = std::max(least_m, std::sqrt(std::max(0.0, inside)));
  // Beyond the tangent the range is that of the tangent, and further away the farther it misses.
  const double missed_m = std::max(0.0, std::abs(across_m) - radius_m);
  const double range_m =
      along_m + side * (std::sqrt(std::max(0.0, inside)) - missed_m * radius_m / least_m);
  return {range_m, across_m / half_chord_m, half_chord_m, side};
}

double variance_of(const CircleRay& ray, const Prediction& at) {
  return ray.range_sigma_m * ray.range_sigma_m +
         std::pow(at.slope * at.range_m * ray.bearing_sigma_rad, 2);
}

void add_hit(const CircleRay& ray, const FittedCircle& circle, Sums& sums) {
  const Prediction at = predict(ray, circle);
  const double variance = variance_of(ray, at);
  Eigen::Vector3d jacobian;
  jacobian.head<2>() =
      ray.direction - at.side * at.slope * Eigen::Vector2d(-ray.direction.y(), ray.direction.x());
  jacobian[2] = at.side * circle.radius_m / at.half_chord_m;
  const double residual = ray.range_m - at.range_m;
  sums.add(jacobian, residual, 1.0 / variance);
  sums.cost += residual * residual / variance;
  sums.chi2 += residual * residual / variance;
  ++sums.hits;
}

void add_passed(const CircleRay& ray, const FittedCircle& circle, Sums& sums) {
  const double across_m = left_distance(ray, circle.centre_m);
  const double inside_m = circle.radius_m - std::abs(across_m);
  const double along_m = ray.direction.dot(circle.centre_m - ray.origin_m);
  if (inside_m <= 0.0 || along_m <= 0.0) return;
  const double side = across_m < 0.0 ? -1.0 : 1.0;
  const double variance = kEdgeSigmaM * kEdgeSigmaM + std::pow(along_m * ray.bearing_sigma_rad, 2);
  Eigen::Vector3d jacobian;  // of |across| - radius, measured to be 0 or more
  jacobian.head<2>() = side * Eigen::Vector2d(-ray.direction.y(), ray.direction.x());
  jacobian[2] = -1.0;
  sums.add(jacobian, inside_m, 1.0 / variance);
  sums.cost += inside_m * inside_m / variance;
}

Sums sums_of(std::span<const CircleRay> rays, const FittedCircle& circle) {
  Sums sums;
  for (const CircleRay& ray : rays) {
    if (ray.hit) {
      add_hit(ray, circle, sums);
    } else {
      add_passed(ray, circle, sums);
    }
  }
  return sums;
}

}  // namespace

std::optional<FittedCircle> fit_circle(std::span<const CircleRay> rays, FittedCircle start) {
  FittedCircle circle = start;
  Sums sums = sums_of(rays, circle);
  if (sums.hits < 3) return {};
  double damping = 1e-3;
  for (int i = 0; i < kMostIterations; ++i) {
    Eigen::Matrix3d matrix = sums.information;
    matrix.diagonal() *= 1.0 + damping;
    const Eigen::Vector3d step = solve_symmetric(matrix, sums.gradient);
    if (!step.allFinite()) return {};
    FittedCircle next = circle;
    next.centre_m += step.head<2>();
    next.radius_m = std::clamp(circle.radius_m + step[2], kLeastFittedM, kLargestFittedM);
    const Sums there = sums_of(rays, next);
    if (there.cost > sums.cost) {
      damping *= 10.0;
      if (damping > 1e9) break;
      continue;
    }
    circle = next;
    sums = there;
    damping = std::max(1e-9, 0.1 * damping);
    if (step.norm() < kConvergedM) break;
  }
  const Eigen::LLT<Eigen::Matrix3d> factor(sums.information);
  if (factor.info() != Eigen::Success || circle.radius_m >= kLargestFittedM) return {};
  circle.covariance = factor.solve(Eigen::Matrix3d::Identity());
  circle.chi2 = sums.chi2;
  circle.bounds_chi2 = sums.cost - sums.chi2;
  circle.hits = sums.hits;
  return circle;
}

double residual_of(const CircleRay& ray, const FittedCircle& circle) {
  const Prediction at = predict(ray, circle);
  return (ray.range_m - at.range_m) / std::sqrt(variance_of(ray, at));
}

}  // namespace marco::slam
