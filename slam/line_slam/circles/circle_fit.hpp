#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace marco::slam {

/// A ray of a laser beside a circle: one that hit it, or one that passed beside it.
struct CircleRay {
  Eigen::Vector2d origin_m;   ///< the sensor
  Eigen::Vector2d direction;  ///< unit
  double range_m = 0.0;       ///< only if `hit`
  double range_sigma_m = 0.01;
  double bearing_sigma_rad = 0.001;
  bool hit = true;
};

/// A circle seen from outside (a post, a leg, a column, a wall that bulges), or from inside (the
/// wall of a round room).
struct FittedCircle {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, radius) [m^2]
  bool from_inside = false;
  double chi2 = 0.0;  ///< of the rays that hit: about their number minus 3 where it is a circle
  double bounds_chi2 = 0.0;  ///< of the rays that should have passed beside and do not
  int hits = 0;
};

/// Fits a circle to rays in one frame, by their ranges: a ray meets the circle where it first
/// enters it (seen from inside: where it leaves it), which is exact also where it grazes. Rays that
/// passed beside bound it. Gauss-Newton with damping (Levenberg) from `start`.
/// @param start  centre and radius about right; says whether it is seen from inside
/// @returns nothing with fewer than three hits, or where the fit leaves all bounds.
std::optional<FittedCircle> fit_circle(std::span<const CircleRay> rays, FittedCircle start);

/// Measured minus predicted range of a ray that hit, in its standard deviations.
double residual_of(const CircleRay& ray, const FittedCircle& circle);

}  // namespace marco::slam
