#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "common/pose2.hpp"
#include "common/wall.hpp"

namespace marco {

/// Counter-clockwise from one direction to another, 0 to 2 pi.
inline double turn_between(double from_rad, double to_rad) {
  const double turn = normalize_angle(to_rad - from_rad);
  return turn < 0.0 ? turn + 2.0 * std::numbers::pi : turn;
}

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
  constexpr double kNearM = 0.001;  // what is promised above
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

/// The piece as straight walls with its own id, less than 1 mm off it, for who takes only such.
inline Walls chords_of(const RoundWall& round) {
  std::vector<Eigen::Vector2d> points = outline_of(round);
  if (!round.from_inside) std::reverse(points.begin(), points.end());
  Walls chords;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    Wall& chord = chords.emplace_back();
    chord.id = round.id;
    chord.start_m = points[i];
    chord.end_m = points[i + 1];
    // Both ends move with the centre, and outwards with the radius.
    Eigen::Matrix<double, 4, 3> by_circle;
    by_circle << 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0;
    by_circle.col(2).head<2>() = (chord.start_m - round.centre_m).normalized();
    by_circle.col(2).tail<2>() = (chord.end_m - round.centre_m).normalized();
    chord.covariance = by_circle * round.covariance * by_circle.transpose();
    chord.existence = round.existence;
    chord.times_seen = round.times_seen;
  }
  return chords;
}

}  // namespace marco
