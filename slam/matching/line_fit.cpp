#include "slam/matching/line_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "slam/matching/estimator.hpp"

namespace marco::slam {
namespace {

void require_fittable(const Points2& points) {
  require(points.cols() >= 2, "a line fit needs at least 2 points");
  require(points.allFinite(), "a line fit needs finite points");
}

Line line_from_slope(double a, double b, const Points2& points) {
  Line line;
  line.direction = Eigen::Vector2d(1.0, a).normalized();
  const double x_m = points.row(0).mean();
  line.centroid = Eigen::Vector2d(x_m, a * x_m + b);
  const Eigen::VectorXd across = line.normal().transpose() * (points.colwise() - line.centroid);
  line.rms_m = std::sqrt(across.squaredNorm() / static_cast<double>(points.cols()));
  return line;
}

Eigen::Vector2d least_squares_slope(const Points2& points) {
  require_fittable(points);
  const double n = static_cast<double>(points.cols());
  const double x = points.row(0).sum(), y = points.row(1).sum();
  const double xx = points.row(0).squaredNorm(), xy = points.row(0).dot(points.row(1));
  const double divisor = n * xx - x * x;
  require(divisor > 1e-12 * (1.0 + n * xx), "a fit of y on x needs points of different x");
  return {(n * xy - x * y) / divisor,    // (E.7)
          (y * xx - x * xy) / divisor};  // (E.8)
}

double lorentzian_cost(const Points2& points,
                       const Estimator& estimator,
                       const Eigen::Vector2d& ab) {
  double cost = 0.0;
  for (const auto& p : points.colwise()) cost += estimator.rho(ab[0] * p.x() + ab[1] - p.y());
  return cost;  // (E.10)
}

/// One run of Newton with damping at a fixed sigma.
Eigen::Vector2d descend(const Points2& points, const Estimator& estimator, Eigen::Vector2d ab) {
  double lambda = 1e-3;
  double cost = lorentzian_cost(points, estimator, ab);
  for (int step = 0; step < 100 && lambda < 1e12; ++step) {
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero(), scale = Eigen::Vector2d::Zero();
    Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
    for (const auto& p : points.colwise()) {
      const double e = ab[0] * p.x() + ab[1] - p.y();
      const Eigen::Vector2d j(p.x(), 1.0);
      gradient += estimator.influence(e) * j;                 // (E.14), (E.15)
      hessian += estimator.curvature(e) * j * j.transpose();  // (E.16)-(E.19)
      scale += estimator.weight(e) * j.cwiseAbs2();
    }
    Eigen::Matrix2d damped = hessian;
    damped.diagonal() += lambda * scale;
    const Eigen::LLT<Eigen::Matrix2d> llt(damped);
    if (llt.info() != Eigen::Success) {
      lambda *= 10.0;
      continue;
    }
    const Eigen::Vector2d trial = ab - llt.solve(gradient);  // (E.13)
    const double trial_cost = lorentzian_cost(points, estimator, trial);
    if (!(trial_cost < cost)) {
      lambda *= 10.0;
      continue;
    }
    const bool done = cost - trial_cost < 1e-14 * (1.0 + cost);
    ab = trial;
    cost = trial_cost;
    lambda /= 10.0;
    if (done) break;
  }
  return ab;
}

}  // namespace

Line fit_least_squares(const Points2& points) {
  const Eigen::Vector2d ab = least_squares_slope(points);
  return line_from_slope(ab[0], ab[1], points);
}

Line fit_lorentzian(const Points2& points, double sigma_m) {
  require(sigma_m > 0.0, "fit_lorentzian: sigma_m must be > 0 m");
  Eigen::Vector2d ab = least_squares_slope(points);
  double wide_m = std::max(sigma_m, line_from_slope(ab[0], ab[1], points).rms_m);
  while (wide_m > sigma_m) {
    ab = descend(points, {EstimatorKind::lorentzian, wide_m}, ab);
    wide_m *= 0.5;
  }
  ab = descend(points, {EstimatorKind::lorentzian, sigma_m}, ab);
  return line_from_slope(ab[0], ab[1], points);
}

Line fit_principal_components(const Points2& points) {
  require_fittable(points);
  LineSums sums;
  for (const auto& p : points.colwise()) sums.add(p);
  return sums.line();
}

void LineSums::add(const Eigen::Vector2d& point) {
  if (count_ == 0) reference_ = point;
  ++count_;
  count(point, 1.0);
}

void LineSums::remove(const Eigen::Vector2d& point) {
  --count_;
  count(point, -1.0);
}

void LineSums::count(const Eigen::Vector2d& point, double sign) {
  const Eigen::Vector2d p = point - reference_;
  sum_ += sign * p;
  xx_ += sign * p.x() * p.x();
  xy_ += sign * p.x() * p.y();
  yy_ += sign * p.y() * p.y();
}

Line LineSums::line() const {
  const double n = count_;
  const Eigen::Vector2d mean = sum_ / n;  // (E.24), (E.25)
  const double cxx = xx_ / n - mean.x() * mean.x(), cxy = xy_ / n - mean.x() * mean.y();
  const double cyy = yy_ / n - mean.y() * mean.y();  // (E.20)-(E.23)
  // (E.28)-(E.30), with the half-angle form of the eigenvector, which has no case left out.
  const double root = std::sqrt((cxx - cyy) * (cxx - cyy) + 4.0 * cxy * cxy);
  const double angle_rad = 0.5 * std::atan2(2.0 * cxy, cxx - cyy);
  Line line;
  line.centroid = reference_ + mean;
  line.direction = {std::cos(angle_rad), std::sin(angle_rad)};
  line.rms_m = std::sqrt(std::max(0.0, 0.5 * (cxx + cyy - root)));
  return line;
}

}  // namespace marco::slam
