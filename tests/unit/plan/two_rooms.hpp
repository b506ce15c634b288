#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "slam/map/keyframe.hpp"

namespace marco::plan::testing {

/// A scan of 360 beams around the robot. @param range_of  (place, direction) in the world [m]
template <class RangeOf>
slam::Keyframe look_around(const Pose2& world_from_robot,
                           const RangeOf& range_of,
                           std::mt19937& random) {
  constexpr double kSigmaM = 0.005;
  std::normal_distribution<double> noise(0, kSigmaM);
  slam::Keyframe key;
  key.world_from_robot = world_from_robot;
  Points2 points(2, 360);
  for (int i = 0; i < 360; ++i) {
    const double angle = deg_to_rad(i), in_world = angle + world_from_robot.theta_rad;
    const Eigen::Vector2d way(std::cos(in_world), std::sin(in_world));
    const double range = range_of(world_from_robot.translation_m(), way) + noise(random);
    points.col(i) = range * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  key.points_in_robot = slam::orient(points, Eigen::Vector2d::Zero(), {}, kSigmaM);
  return key;
}

/// Two rooms of 4 x 3 m and 3 x 3 m (clear), a wall of 0.12 m between them with a door of 0.88 m,
/// a cupboard of 1 x 0.5 m at the left one's upper wall, a column of 0.15 m radius in the right
/// one. Keyframes stand on a grid of 0.5 m, with ranges of 5 mm noise.
/// @param turn_rad  of the building in the map
/// @param leaf  the door has a leaf, open into the right room, and a thing stands in the left one
/// whose face lies on one line with it
inline std::vector<slam::Keyframe> two_rooms(double turn_rad, bool leaf = false) {
  using Vector = Eigen::Vector2d;
  std::vector<std::array<Vector, 2>> walls;
  const auto box = [&walls](double x0, double y0, double x1, double y1) {
    const std::array<Vector, 4> corners{Vector(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}};
    for (std::size_t i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4]});
  };
  box(0, 0, 7.12, 3);
  box(4, -1, 4.12, 1);
  box(4, 1.88, 4.12, 4);
  box(1.5, 2.5, 2.5, 3.5);
  if (leaf) {
    box(4.14, 1.86, 4.98, 1.90);
    box(3.3, 1.87, 3.75, 2.2);
  }
  const Vector column(5.8, 1.0);
  const auto range_of = [&](const Vector& at, const Vector& way) {
    double nearest = 30;
    for (const auto& [a, b] : walls) {
      const Vector along = b - a, off = a - at;
      const double turn = way.x() * along.y() - way.y() * along.x();
      if (std::abs(turn) < 1e-12) continue;
      const double s = (off.x() * along.y() - off.y() * along.x()) / turn;
      const double u = (off.x() * way.y() - off.y() * way.x()) / turn;
      if (s > 0 && u >= 0 && u <= 1) nearest = std::min(nearest, s);
    }
    const double middle = way.dot(column - at);
    const double gap = 0.15 * 0.15 - ((column - at).squaredNorm() - middle * middle);
    if (gap > 0 && middle > 0) nearest = std::min(nearest, middle - std::sqrt(gap));
    return nearest;
  };
  const auto is_clear = [&](double x, double y) {
    if (std::abs(x - 4.06) < 0.25 && std::abs(y - 1.44) > 0.2) return false;
    if (x > 1.2 && x < 2.8 && y > 2.2) return false;
    if (leaf && x > 3.1 && x < 5.2 && std::abs(y - 1.95) < 0.3) return false;
    return (Vector(x, y) - column).norm() > 0.4;
  };
  std::mt19937 random(7);
  std::vector<slam::Keyframe> keys;
  for (double x = 0.5; x < 6.8; x += 0.5) {
    for (double y = 0.5; y < 2.8; y += 0.47) {
      if (!is_clear(x, y)) continue;
      keys.push_back(look_around({x, y, 0.7 * x}, range_of, random));
      keys.back().world_from_robot = Pose2{0, 0, turn_rad} * keys.back().world_from_robot;
    }
  }
  return keys;
}

}  // namespace marco::plan::testing
