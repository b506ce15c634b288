#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "common/laser_scan.hpp"
#include "common/pose2.hpp"

namespace marco::testing {

/// A floor plan of straight walls, and what an ideal laser sees of it: every ray against every
/// wall.
struct FlatWorld {
  struct Wall {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
  };
  std::vector<Wall> walls;

  void add_chain(const std::vector<Eigen::Vector2d>& corners) {
    for (std::size_t i = 0; i + 1 < corners.size(); ++i)
      walls.push_back({corners[i], corners[i + 1]});
  }
  void add_box(double x0, double y0, double x1, double y1) {
    add_chain({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}, {x0, y0}});
  }

  /// Range along a ray, infinite where nothing is hit.
  double range_m(const Eigen::Vector2d& from, double bearing_rad) const {
    const Eigen::Vector2d ray(std::cos(bearing_rad), std::sin(bearing_rad));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls) {
      const Eigen::Vector2d along = wall.to - wall.from, start = wall.from - from;
      const double det = along.x() * ray.y() - along.y() * ray.x();
      if (std::abs(det) < 1e-12) continue;
      const double range = (along.x() * start.y() - along.y() * start.x()) / det;
      const double part = (ray.x() * start.y() - ray.y() * start.x()) / det;
      if (range > 0.0 && part >= 0.0 && part <= 1.0) nearest = std::min(nearest, range);
    }
    return nearest;
  }

  /// 361 beams over 180 degrees; sigma_m of noise when `random` is given; 0 = no return.
  LaserScan scan(const Pose2& world_from_robot,
                 double sigma_m = 0.0,
                 std::mt19937* random = nullptr) const {
    LaserScan scan;
    scan.first_bearing_rad = deg_to_rad(-90.0);
    scan.bearing_step_rad = deg_to_rad(0.5);
    std::normal_distribution<double> noise(0.0, 1.0);
    for (int beam = 0; beam < 361; ++beam) {
      const double bearing = world_from_robot.theta_rad + deg_to_rad(-90.0 + 0.5 * beam);
      const double range = range_m(world_from_robot.translation_m(), bearing);
      const double error = random != nullptr ? sigma_m * noise(*random) : 0.0;
      scan.ranges_m.push_back(std::isfinite(range) ? static_cast<float>(range + error) : 0.0F);
    }
    return scan;
  }

  Points2 hits(const Pose2& world_from_robot,
               double sigma_m = 0.0,
               std::mt19937* random = nullptr) const {
    const LaserScan seen = scan(world_from_robot, sigma_m, random);
    Points2 hits(2, static_cast<Eigen::Index>(seen.size()));
    Eigen::Index count = 0;
    for (std::size_t beam = 0; beam < seen.size(); ++beam) {
      const auto range = static_cast<double>(seen.ranges_m[beam]);
      if (range <= 0.0) continue;
      hits.col(count++) = range * Eigen::Vector2d(std::cos(seen.bearing_rad(beam)),
                                                  std::sin(seen.bearing_rad(beam)));
    }
    hits.conservativeResize(2, count);
    return hits;
  }
};

/// A room 8 x 6 m with a box and a niche: no symmetry a matcher could fall for.
inline FlatWorld small_room() {
  FlatWorld world;
  world.add_chain(
      {{-4, -3}, {4, -3}, {4, 1}, {4.8, 1}, {4.8, 2}, {4, 2}, {4, 3}, {-4, 3}, {-4, -3}});
  world.add_box(1.5, -1.6, 2.3, -1.0);
  world.add_box(-2.5, 1.4, -2.1, 2.2);
  return world;
}

}  // namespace marco::testing
