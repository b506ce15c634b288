#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "common/footprint.hpp"
#include "common/laser_scan.hpp"

namespace marco::drivers::testing {

/// A thing on the floor: a straight wall with round ends; a post where they are one.
struct Thing {
  Eigen::Vector2d a, b;
  double radius_m = 0.0;  ///< half of its thickness
};

inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Posts, thin legs, walls and doors, in a room of 8 m.
struct GuardWorld {
  std::vector<Thing> things;

  void post(double x, double y, double radius_m) { things.push_back({{x, y}, {x, y}, radius_m}); }
  void wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    things.push_back({from, to, 0.03});
  }
  void room(double half_m) {
    const double h = half_m;
    wall({-h, -h}, {h, -h});
    wall({h, -h}, {h, h});
    wall({h, h}, {-h, h});
    wall({-h, h}, {-h, -h});
  }

  /// Nothing stands within 0.8 m of the origin.
  static GuardWorld random(std::mt19937& random) {
    const auto draw = [&](double a, double b) {
      return std::uniform_real_distribution<double>(a, b)(random);
    };
    GuardWorld world;
    world.room(4.0);
    for (int i = 0; i < 8; ++i) {
      const double x = draw(-3.5, 3.5), y = draw(-3.5, 3.5), r = draw(0.03, 0.3);
      if (std::hypot(x, y) > 0.8 + r) world.post(x, y, r);
    }
    for (int i = 0; i < 8; ++i) {  // legs of chairs and tables
      const double x = draw(-3.5, 3.5), y = draw(-3.5, 3.5);
      if (std::hypot(x, y) > 0.9) world.post(x, y, 0.015);
    }
    if (random() % 2 == 0) {  // a wall across with a door in it
      const double x = draw(1.2, 2.5), door = draw(-2.5, 2.5), half = draw(0.35, 0.6);
      world.wall({x, -4.0}, {x, door - half});
      world.wall({x, door + half}, {x, 4.0});
    }
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d from(draw(-3.5, 3.5), draw(-3.5, 3.5));
      const double way = draw(-3.1, 3.1);
      const Eigen::Vector2d to =
          from + draw(0.4, 1.5) * Eigen::Vector2d(std::cos(way), std::sin(way));
      const double part = std::clamp(-from.dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
      if ((from + part * (to - from)).norm() > 0.9) world.wall(from, to);
    }
    return world;
  }

  /// @returns infinity: nothing is there.
  double range_m(const Eigen::Vector2d& from, double bearing_rad) const {
    const Eigen::Vector2d along(std::cos(bearing_rad), std::sin(bearing_rad));
    double least_m = std::numeric_limits<double>::infinity();
    const auto take = [&](double range_m) {
      if (range_m > 0.0) least_m = std::min(least_m, range_m);
    };
    for (const Thing& thing : things) {
      take(to_circle(thing.a, thing.radius_m, from, along));
      if (thing.a == thing.b) continue;
      take(to_circle(thing.b, thing.radius_m, from, along));
      const Eigen::Vector2d side = thing.radius_m * turned_left((thing.b - thing.a).normalized());
      take(to_line(thing.a + side, thing.b + side, from, along));
      take(to_line(thing.a - side, thing.b - side, from, along));
    }
    return least_m;
  }

  struct Gap {
    double gap_m = std::numeric_limits<double>::infinity();  ///< <= 0: it touches
    Eigen::Vector2d at;                                      ///< where: of the thing's surface
  };
  Gap gap(const Footprint& body, const Pose2& world_from_robot) const {
    const Pose2 robot_from_world = world_from_robot.inverse();
    Gap least;
    for (const Thing& thing : things) {
      const Eigen::Vector2d a = robot_from_world * thing.a, b = robot_from_world * thing.b;
      const double part =
          a == b ? 0.0 : std::clamp(-a.dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
      const double from_middle_m = (a + part * (b - a)).norm() - thing.radius_m;
      if (from_middle_m - body.radius_m() >= least.gap_m) continue;  // cannot be nearer
      const Eigen::Vector2d nearest = nearest_to(body, a, b);
      const double gap_m = body.distance_m(nearest) - thing.radius_m;
      if (gap_m >= least.gap_m) continue;
      const Eigen::Vector2d x(1e-4, 0.0), y(0.0, 1e-4);
      const Eigen::Vector2d away(body.distance_m(nearest + x) - body.distance_m(nearest - x),
                                 body.distance_m(nearest + y) - body.distance_m(nearest - y));
      const Eigen::Vector2d at = nearest - thing.radius_m * away.normalized();
      least = {gap_m, world_from_robot * at};
    }
    return least;
  }

 private:
  static double to_circle(const Eigen::Vector2d& middle,
                          double radius_m,
                          const Eigen::Vector2d& from,
                          const Eigen::Vector2d& along) {
    const Eigen::Vector2d to = middle - from;
    const double off = cross(to, along), inside = radius_m * radius_m - off * off;
    return inside < 0.0 ? -1.0 : to.dot(along) - std::sqrt(inside);
  }
  static double to_line(const Eigen::Vector2d& a,
                        const Eigen::Vector2d& b,
                        const Eigen::Vector2d& from,
                        const Eigen::Vector2d& along) {
    const Eigen::Vector2d edge = b - a, to = a - from;
    const double turn = cross(along, edge);
    if (turn == 0.0) return -1.0;
    const double part = cross(to, along) / turn;
    return part < 0.0 || part > 1.0 ? -1.0 : cross(to, edge) / turn;
  }
  /// The point of a segment that is nearest to the body, or deepest in it, to a millimetre.
  static Eigen::Vector2d nearest_to(const Footprint& body,
                                    const Eigen::Vector2d& a,
                                    const Eigen::Vector2d& b) {
    // The distance is convex along the segment, since the body is.
    const Eigen::Vector2d way = b - a;
    double from = 0.0, to = 1.0;
    while ((to - from) * way.norm() > 0.001) {
      const double third = (to - from) / 3.0;
      const bool first =
          body.distance_m(a + (from + third) * way) < body.distance_m(a + (to - third) * way);
      (first ? to : from) += first ? -third : third;
    }
    return a + (from + to) / 2.0 * way;
  }
};

}  // namespace marco::drivers::testing
