#pragma once

#include <Eigen/Core>

namespace marco::slam {

constexpr double square(double value) { return value * value; }

/// Weighted sums over points, from which a line is fitted without another look at the points.
struct LineSums {
  double weight = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;

  void add(const LineSums& other, double sign);
  void add_point(double x_m, double y_m, double point_weight);

  /// Of the linear regression of y on x: weighted sum of squared residuals, and its value at x_m.
  double regression_residual() const;
  double regression_at(double x_m) const;
};

/// A line through its points' centroid.
struct FittedLine {
  double center_x = 0.0, center_y = 0.0;
  double along_x = 1.0, along_y = 0.0;  ///< unit vector
  double rms_m = 0.0;                   ///< weighted distance of its points

  double across_of(const Eigen::Vector2d& p) const { return across_of(p.x(), p.y()); }
  double across_of(double x, double y) const {
    return along_x * (y - center_y) - along_y * (x - center_x);
  }
  double along_of(double x, double y) const {
    return along_x * (x - center_x) + along_y * (y - center_y);
  }
};

/// Total least squares line fitting: the principal axis of the points.
FittedLine fit_line(const LineSums& sums);

}  // namespace marco::slam
