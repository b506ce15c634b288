#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace marco::slam {

/// A straight line through points.
struct Line {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();    ///< a point on the line [m]
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< unit; sign without meaning
  double rms_m = 0.0;                                    ///< of the points' distances to the line

  Eigen::Vector2d normal() const { return {-direction.y(), direction.x()}; }
  /// Nearest point on the line (thesis B eq. E.31-E.32).
  Eigen::Vector2d project(const Eigen::Vector2d& point) const {
    return centroid + direction * direction.dot(point - centroid);
  }
  double distance_m(const Eigen::Vector2d& point) const {
    return std::abs(normal().dot(point - centroid));
  }
};

/// The three line fits of thesis B, appendix E. All: `points` 2×N [m], N >= 2, in any
/// order. @throws std::invalid_argument for N < 2 or a coordinate that is not finite; the two
/// y-on-x fits also when all x are equal.

/// y = ax + b by least squares (E.7, E.8): errors along y, so not for steep lines.
Line fit_least_squares(const Points2& points);

/// y = ax + b by the Lorentzian (E.10-E.19), from the least-squares line, by Newton with
/// Levenberg-Marquardt damping; sigma runs from the least-squares error down to `sigma_m`, without
/// which one outlier near the start holds the line. (E.16 and E.17 lose a factor x_i² and x_i on
/// one line of the print; here they are right.)
Line fit_lorentzian(const Points2& points, double sigma_m);

/// Principal components (E.20-E.30): errors across the line, any direction.
Line fit_principal_components(const Points2& points);

/// Running sums of a principal-component fit: add and take away points in O(1).
class LineSums {
 public:
  void add(const Eigen::Vector2d& point);
  void remove(const Eigen::Vector2d& point);
  int size() const { return count_; }
  /// Of the points added (E.20-E.30). Needs two or more.
  Line line() const;

 private:
  void count(const Eigen::Vector2d& point, double sign);
  int count_ = 0;
  Eigen::Vector2d reference_ = Eigen::Vector2d::Zero();  // first point: keeps far sums exact
  Eigen::Vector2d sum_ = Eigen::Vector2d::Zero();
  double xx_ = 0.0, xy_ = 0.0, yy_ = 0.0;
};

}  // namespace marco::slam
