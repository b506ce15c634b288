#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace marco {

/// A post, a column or a piece of a curved wall: a circle or a part of it.
struct RoundWall {
  int64_t id = 0;  ///< of the map; pieces of one circle share it
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();  ///< world frame
  double radius_m = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, radius) [m^2]
  bool from_inside = false;                              ///< free space lies on the centre's side
  double from_rad = 0.0;  ///< direction from the centre to where the piece begins ...
  double span_rad = 2.0 * std::numbers::pi;  ///< ... and how far it goes counter-clockwise
  double existence = 1.0;                    ///< probability that it stands there now, 0..1
  int64_t times_seen = 0;                    ///< scans that it was found in

  bool is_whole() const { return span_rad >= 2.0 * std::numbers::pi - 1e-9; }
};

using RoundWalls = std::vector<RoundWall>;

/// The piece as a chain of points, no farther than 1 mm from it in between; closed where it is
/// whole.
inline std::vector<Eigen::Vector2d> outline_of(const RoundWall& wall) {
  constexpr double kNearM = 0.001;
  const double step_rad = 2.0 * std::sqrt(2.0 * kNearM / std::max(0.01, wall.radius_m));
  const int steps = std::max(2, static_cast<int>(std::ceil(wall.span_rad / step_rad)));
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i <= steps; ++i) {
    const double angle = wall.from_rad + wall.span_rad * i / steps;
    outline.push_back(wall.centre_m +
                      wall.radius_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return outline;
}

}  // namespace marco
