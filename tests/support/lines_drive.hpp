#pragma once

#include <random>
#include <vector>

#include "common/pose2.hpp"

namespace marco::testing {

/// A drive through waypoints in steps, with what odometry says of each step.
struct LinesDrive {
  std::vector<Pose2> world_from_robot;  ///< truth, first pose before the first step
  std::vector<Pose2> odometry_steps;    ///< one a step, with errors
};

struct LinesOdometryErrors {
  double distance_part = 0.03;  ///< standard deviation along, of the way
  double heading_part = 0.03;   ///< of the turn
  double heading_rad_per_m = 0.01;
  double floor_m = 0.001;
  double floor_rad = 0.0005;
};

/// Turns on the spot towards each waypoint, then goes there, in steps of at most step_m, step_rad.
inline LinesDrive drive(const std::vector<Eigen::Vector2d>& waypoints_m,
                        double step_m,
                        double step_rad,
                        const LinesOdometryErrors& errors,
                        std::mt19937& random) {
  std::normal_distribution<double> normal(0.0, 1.0);
  LinesDrive result;
  Pose2 pose{waypoints_m[0].x(), waypoints_m[0].y(), 0.0};
  result.world_from_robot.push_back(pose);
  const auto step = [&](const Pose2& truth) {
    const double d = truth.x_m, turn = truth.theta_rad;
    const double sigma_m = std::hypot(errors.distance_part * d, errors.floor_m);
    const double sigma_rad =
        std::hypot(errors.heading_part * turn, errors.heading_rad_per_m * d, errors.floor_rad);
    result.odometry_steps.push_back({d + sigma_m * normal(random), errors.floor_m * normal(random),
                                     turn + sigma_rad * normal(random)});
    pose = pose * truth;
    result.world_from_robot.push_back(pose);
  };
  for (std::size_t i = 1; i < waypoints_m.size(); ++i) {
    const Eigen::Vector2d way = waypoints_m[i] - pose.translation_m();
    const double turn = normalize_angle(std::atan2(way.y(), way.x()) - pose.theta_rad);
    const int turns = static_cast<int>(std::ceil(std::abs(turn) / step_rad));
    for (int k = 0; k < turns; ++k) step({0.0, 0.0, turn / turns});
    const int moves = static_cast<int>(std::ceil(way.norm() / step_m));
    for (int k = 0; k < moves; ++k) step({way.norm() / moves, 0.0, 0.0});
  }
  return result;
}

}  // namespace marco::testing
