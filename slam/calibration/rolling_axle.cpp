#include "slam/calibration/rolling_axle.hpp"

#include <cmath>

#include "common/linear_algebra.hpp"

namespace marco::slam {

OdometryCalibration axle_of(const std::vector<LaserMotion>& motions, const OdometryTravel& travel) {
  constexpr double kSlides = 0.02;         // of the way: less is rounding, and wheels that slip
  constexpr double kLeastTurnedRad = 0.5;  // root of the sum of squares: else x is not observable
  OdometryCalibration axle;
  Eigen::Matrix3d form = Eigen::Matrix3d::Zero();
  for (const LaserMotion& motion : motions) {
    const ArcMotion counted = travel.between_moments(motion.begin_s, motion.end_s);
    const Eigen::Vector3d row(counted.ahead_m, counted.left_m, counted.turn_rad);
    form += row * row.transpose();
  }
  const double way2 = form(0, 0) + form(1, 1);
  if (form(1, 1) < kSlides * kSlides * way2) return axle;
  // Least squares of -sin(yaw) ahead + cos(yaw) (left + x turn); x by Schur's complement.
  const bool turns = form(2, 2) > kLeastTurnedRad * kLeastTurnedRad;
  const Eigen::Vector2d coupling = form.topRightCorner<2, 1>();
  Eigen::Matrix2d sliding = form.topLeftCorner<2, 2>();
  if (turns) sliding -= coupling * coupling.transpose() / form(2, 2);
  const auto [values, vectors] = eigenpairs_of(sliding);
  if (values.x() > kSlides * kSlides * way2) return axle;
  Eigen::Vector2d across = vectors.col(0);
  if (across.y() < 0.0) across = -across;
  axle.axle_yaw_deg = rad_to_deg(std::atan2(-across.x(), across.y()));
  if (turns && across.y() > 0.1) {
    axle.axle_x_m = -coupling.dot(across) / (form(2, 2) * across.y());
  }
  return axle;
}

}  // namespace marco::slam
