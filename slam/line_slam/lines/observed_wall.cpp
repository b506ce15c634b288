#include "slam/line_slam/lines/observed_wall.hpp"

namespace marco::slam {

Eigen::Matrix4d ObservedWall::covariance() const {
  const Eigen::Vector2d u = along(), n = across();
  // Columns: across offset at the centre, direction, the two ends' own errors along the wall.
  Eigen::Matrix4d spread;
  spread << n.x() * across_sigma_m, n.x() * u.dot(start_m - center_m) * direction_sigma_rad,
      u.x() * start_sigma_m, 0.0,  //
      n.y() * across_sigma_m, n.y() * u.dot(start_m - center_m) * direction_sigma_rad,
      u.y() * start_sigma_m, 0.0,  //
      n.x() * across_sigma_m, n.x() * u.dot(end_m - center_m) * direction_sigma_rad, 0.0,
      u.x() * end_sigma_m,  //
      n.y() * across_sigma_m, n.y() * u.dot(end_m - center_m) * direction_sigma_rad, 0.0,
      u.y() * end_sigma_m;
  return spread * spread.transpose();
}

}  // namespace marco::slam
