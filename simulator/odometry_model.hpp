#pragma once

#include <random>

#include "common/pose2.hpp"
#include "simulator/simulation_options.hpp"

namespace marco::sim {

/// Odometry with systematic errors, drift and slip, from the true pose at a steady rate.
class OdometryModel {
 public:
  /// Draws this run's signs from `random`.
  OdometryModel(const OdometryOptions& options,
                const Pose2& world_from_robot,
                std::mt19937_64& random);

  /// @returns odom_from_robot after the robot moved to `world_from_robot`.
  const Pose2& move_to(const Pose2& world_from_robot, std::mt19937_64& random);

 private:
  OdometryOptions options_;
  double distance_scale_;
  double turn_scale_;
  double drift_rad_per_m_;
  double to_next_slip_m_ = 0.0;
  Pose2 world_from_robot_;
  Pose2 odom_from_robot_;
};

}  // namespace marco::sim
