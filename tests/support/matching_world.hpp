#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "common/pose2.hpp"

namespace marco::testing {

/// A flat world of wall pieces with its own exact ray caster: truth for the matching tests.
class MatchingWorld {
 public:
  /// A wall from one corner to the next, for each neighbouring two [m].
  void add_walls(const std::vector<Eigen::Vector2d>& corners) {
    for (std::size_t i = 0; i + 1 < corners.size(); ++i)
      walls_.push_back({corners[i], corners[i + 1]});
  }
  void add_box(double x0, double y0, double x1, double y1) {
    add_walls({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}, {x0, y0}});
  }

  struct Hit {
    double range_m = std::numeric_limits<double>::infinity();
    Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< of the wall, world frame
    int wall = -1;
  };
  Hit cast(const Eigen::Vector2d& from, double bearing_rad) const {
    const Eigen::Vector2d ray(std::cos(bearing_rad), std::sin(bearing_rad));
    Hit best;
    for (std::size_t i = 0; i < walls_.size(); ++i) {
      const Wall& wall = walls_[i];
      const Eigen::Vector2d along = wall.b - wall.a, to = wall.a - from;
      const double cross = ray.x() * along.y() - ray.y() * along.x();
      if (std::abs(cross) < 1e-12) continue;
      const double range = (to.x() * along.y() - to.y() * along.x()) / cross;
      const double part = (to.x() * ray.y() - to.y() * ray.x()) / cross;
      if (range > 1e-6 && range < best.range_m && part >= 0.0 && part <= 1.0) {
        best = {range, Eigen::Vector2d(-along.y(), along.x()).normalized(), static_cast<int>(i)};
      }
    }
    return best;
  }
  int wall_count() const { return static_cast<int>(walls_.size()); }

 private:
  struct Wall {
    Eigen::Vector2d a, b;
  };
  std::vector<Wall> walls_;
};

struct MatchingLaser {
  int beams = 361;
  double first_rad = -std::numbers::pi / 2;
  double step_rad = std::numbers::pi / 360;
  double noise_m = 0.01;      ///< Gaussian, of each range
  double outlier_part = 0.0;  ///< so many beams have a range uniform in (0.1 m, max)
  double max_range_m = 32.0;  ///< beams that reach no wall within it give no point
};

/// A beam that met a wall.
struct WallBeam {
  int wall = 0;
  Eigen::Vector2d point, normal;  ///< robot's frame
};

struct MatchingScan {
  Points2 points_in_robot;        ///< in sweep order
  std::vector<WallBeam> inliers;  ///< those of its beams that are no outliers
  Eigen::Matrix3d fisher;         ///< of (x, y, theta) of the robot in its own axes, from the
                                  ///< inlier beams at noise_m: its inverse bounds one scan
};

/// One scan from `world_from_robot`.
inline MatchingScan take_scan(const MatchingWorld& world,
                              const Pose2& world_from_robot,
                              const MatchingLaser& laser,
                              std::mt19937& random) {
  std::normal_distribution<double> gauss(0.0, 1.0);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  MatchingScan scan{Points2(2, laser.beams), {}, Eigen::Matrix3d::Zero()};
  int count = 0;
  const Eigen::Matrix2d robot_from_world = world_from_robot.rotation().transpose();
  for (int i = 0; i < laser.beams; ++i) {
    const double bearing_rad = laser.first_rad + i * laser.step_rad;
    const Eigen::Vector2d ray(std::cos(bearing_rad), std::sin(bearing_rad));
    const auto hit =
        world.cast(world_from_robot.translation_m(), world_from_robot.theta_rad + bearing_rad);
    double range_m = hit.range_m + laser.noise_m * gauss(random);
    const bool outlier = uniform(random) < laser.outlier_part;
    if (outlier) range_m = 0.1 + (laser.max_range_m - 0.1) * uniform(random);
    if (!(range_m > 0.0 && range_m < laser.max_range_m)) continue;
    const Eigen::Vector2d point = range_m * ray;
    scan.points_in_robot.col(count++) = point;
    if (outlier) continue;
    // d range / d pose = n^T (1, 1, perp(point)) / n^T ray (Censi, ICRA 2007).
    const Eigen::Vector2d n = robot_from_world * hit.normal;
    const Eigen::Vector3d j(n.x(), n.y(), n.y() * point.x() - n.x() * point.y());
    const double incidence = n.dot(ray) * laser.noise_m;
    scan.fisher += j * j.transpose() / std::max(1e-12, incidence * incidence);
    scan.inliers.push_back({hit.wall, point, n});
  }
  scan.points_in_robot.conservativeResize(2, count);
  return scan;
}

/// A room of 8 by 6 m with a niche, a pillar and two boxes: walls along x and y only.
inline MatchingWorld matching_room() {
  MatchingWorld world;
  world.add_walls({{0, 0},
                   {8, 0},
                   {8, 3},
                   {9, 3},
                   {9, 4.5},
                   {8, 4.5},
                   {8, 6},
                   {3, 6},
                   {3, 6.8},
                   {1.5, 6.8},
                   {1.5, 6},
                   {0, 6},
                   {0, 0}});
  world.add_box(5.5, 2.0, 5.9, 2.4);
  world.add_box(1.0, 0.0, 2.2, 0.7);
  world.add_box(6.8, 5.2, 8.0, 6.0);
  return world;
}

/// Two walls 2 m apart, 60 m long: nothing tells where along it one is.
inline MatchingWorld matching_corridor() {
  MatchingWorld world;
  world.add_walls({{-30, 1}, {30, 1}});
  world.add_walls({{-30, -1}, {30, -1}});
  return world;
}

}  // namespace marco::testing
