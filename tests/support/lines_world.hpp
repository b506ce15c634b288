#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "common/pose2.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::testing {

/// A world of straight walls, ray cast exactly: the small closed world of the line tests.
struct LinesWorld {
  struct Edge {
    Eigen::Vector2d start_m, end_m;  ///< free space on the left
  };
  std::vector<Edge> edges;

  /// Closed polygon, free space inside when counter-clockwise, outside when clockwise.
  void add_polygon(const std::vector<Eigen::Vector2d>& corners_m) {
    for (std::size_t i = 0; i < corners_m.size(); ++i) {
      edges.push_back({corners_m[i], corners_m[(i + 1) % corners_m.size()]});
    }
  }
  /// A solid box seen from outside.
  void add_box(double x0, double y0, double x1, double y1) {
    add_polygon({{x0, y0}, {x0, y1}, {x1, y1}, {x1, y0}});
  }

  struct Hit {
    double range_m = std::numeric_limits<double>::infinity();
    int edge = -1;
  };
  Hit cast(const Eigen::Vector2d& from_m, double bearing_rad) const {
    const Eigen::Vector2d ray(std::cos(bearing_rad), std::sin(bearing_rad));
    Hit nearest;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const Eigen::Vector2d way = edges[i].end_m - edges[i].start_m;
      const Eigen::Vector2d to = edges[i].start_m - from_m;
      const double det = ray.x() * -way.y() + way.x() * ray.y();
      if (std::abs(det) < 1e-12) continue;
      const double range_m = (to.x() * -way.y() + way.x() * to.y()) / det;
      const double part = (ray.x() * to.y() - ray.y() * to.x()) / det;
      if (range_m > 0.0 && part >= 0.0 && part <= 1.0 && range_m < nearest.range_m) {
        nearest = {range_m, static_cast<int>(i)};
      }
    }
    return nearest;
  }
};

struct LinesLaser {
  int beams = 361;
  double first_rad = -0.5 * 3.14159265358979323846;
  double step_rad = 3.14159265358979323846 / 360.0;
  double range_sigma_m = 0.01;
  double max_range_m = 30.0;
  double outlier_part = 0.0;  ///< of the beams: anywhere between 0.3 m and 1 m beyond the wall
  Eigen::Vector2d sensor_m = Eigen::Vector2d::Zero();
};

/// A scan of the world from a pose, with the edge each beam met.
struct LinesScan {
  slam::ScanInRobot scan;
  std::vector<int> edges;  ///< per beam, -1 = none or an outlier
};

inline LinesScan take_scan(const LinesWorld& world,
                           const LinesLaser& laser,
                           const Pose2& world_from_robot,
                           std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, 1.0);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  LinesScan result;
  result.scan.sensor_m = laser.sensor_m;
  result.scan.first_bearing_rad = laser.first_rad;
  result.scan.bearing_step_rad = laser.step_rad;
  result.scan.range_sigma_m = std::max(1e-4, laser.range_sigma_m);
  result.scan.bearing_sigma_rad = 1e-4;
  const Eigen::Vector2d from_m = world_from_robot * laser.sensor_m;
  for (int i = 0; i < laser.beams; ++i) {
    const double bearing_rad = laser.first_rad + i * laser.step_rad;
    const LinesWorld::Hit hit = world.cast(from_m, world_from_robot.theta_rad + bearing_rad);
    slam::Beam beam;
    beam.returned = hit.edge >= 0 && hit.range_m < laser.max_range_m;
    int edge = beam.returned ? hit.edge : -1;
    beam.range_m = hit.range_m + laser.range_sigma_m * noise(random);
    if (laser.outlier_part > 0.0 && uniform(random) < laser.outlier_part) {
      beam.range_m = 0.3 + uniform(random) * (hit.range_m + 0.7);
      edge = -1;
    }
    beam.hit_m = laser.sensor_m +
                 beam.range_m * Eigen::Vector2d(std::cos(bearing_rad), std::sin(bearing_rad));
    result.scan.beams.push_back(beam);
    result.edges.push_back(edge);
  }
  return result;
}

/// Two rooms and a corridor, about 14 m x 10 m: a loop through two doors.
inline LinesWorld make_loop_world() {
  LinesWorld world;
  world.add_polygon({{0, 0}, {14, 0}, {14, 10}, {0, 10}});
  world.add_box(3.0, 3.0, 6.0, 7.0);
  world.add_box(8.0, 3.0, 11.0, 7.0);
  world.add_box(0.0, 4.8, 1.0, 5.2);
  world.add_box(6.8, 0.0, 7.2, 1.2);
  world.add_box(6.8, 8.8, 7.2, 10.0);
  return world;
}

}  // namespace marco::testing
