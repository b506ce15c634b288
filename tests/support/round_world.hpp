#pragma once

#include <vector>

#include "tests/support/lines_world.hpp"

namespace marco::testing {

/// A circle, ray cast exactly: a post, or the wall of a round room.
struct RoundThing {
  Eigen::Vector2d centre_m;
  double radius_m;
  bool from_inside = false;
};

/// Straight walls and round things.
struct RoundWorld {
  LinesWorld walls;
  std::vector<RoundThing> circles;
};

/// Distance to where a ray meets a circle; infinity where it misses.
inline double range_to(const RoundThing& circle,
                       const Eigen::Vector2d& from_m,
                       double bearing_rad) {
  const Eigen::Vector2d ray(std::cos(bearing_rad), std::sin(bearing_rad));
  const Eigen::Vector2d to = circle.centre_m - from_m;
  const double along = ray.dot(to),
               inside = circle.radius_m * circle.radius_m - (to - along * ray).squaredNorm();
  if (inside <= 0.0) return std::numeric_limits<double>::infinity();
  const double range_m = along + (circle.from_inside ? 1.0 : -1.0) * std::sqrt(inside);
  return range_m > 0.0 ? range_m : std::numeric_limits<double>::infinity();
}

struct RoundScan {
  slam::ScanInRobot scan;
  std::vector<int> circles;  ///< per beam: which circle it met, or -1
  Eigen::Vector2d from_m;
  double heading_rad;
};

inline RoundScan round_scan(const RoundWorld& world,
                            const LinesLaser& laser,
                            const Pose2& world_from_robot,
                            std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, laser.range_sigma_m);
  RoundScan result{take_scan(world.walls, laser, world_from_robot, random).scan,
                   {},
                   world_from_robot * laser.sensor_m,
                   world_from_robot.theta_rad};
  for (int i = 0; i < laser.beams; ++i) {
    const double bearing_rad = laser.first_rad + i * laser.step_rad;
    const Eigen::Vector2d ray(std::cos(bearing_rad), std::sin(bearing_rad));
    slam::Beam& beam = result.scan.beams[static_cast<std::size_t>(i)];
    double nearest_m = beam.returned ? beam.range_m : std::numeric_limits<double>::infinity();
    int met = -1;
    for (std::size_t k = 0; k < world.circles.size(); ++k) {
      const double range_m =
          range_to(world.circles[k], result.from_m, result.heading_rad + bearing_rad);
      if (range_m >= nearest_m || range_m > laser.max_range_m) continue;
      nearest_m = range_m;
      met = static_cast<int>(k);
    }
    result.circles.push_back(met);
    if (met < 0) continue;
    beam.returned = true;
    beam.range_m = nearest_m + noise(random);
    beam.hit_m = laser.sensor_m + beam.range_m * ray;
  }
  return result;
}

/// Information that the ranges of a scan hold of (x, y, radius) of a circle: the inverse of Cramer
/// and Rao's bound. Known from the ranges alone, not from the beams that pass beside.
inline Eigen::Matrix3d fisher_of(const RoundScan& seen,
                                 const RoundThing& circle,
                                 int index,
                                 double range_sigma_m) {
  Eigen::Matrix3d fisher = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < seen.circles.size(); ++i) {
    if (seen.circles[i] != index) continue;
    const double bearing_rad = seen.heading_rad + seen.scan.first_bearing_rad +
                               static_cast<double>(i) * seen.scan.bearing_step_rad;
    const Eigen::Vector2d ray(std::cos(bearing_rad), std::sin(bearing_rad));
    const Eigen::Vector2d normal =
        (range_to(circle, seen.from_m, bearing_rad) * ray + seen.from_m - circle.centre_m)
            .normalized();
    Eigen::Vector3d jacobian;  // of the range
    jacobian << normal, 1.0;
    jacobian /= normal.dot(ray);
    fisher += jacobian * jacobian.transpose() / (range_sigma_m * range_sigma_m);
  }
  return fisher;
}

}  // namespace marco::testing
