#include "simulator/odometry_model.hpp"

#include <cmath>
#include <limits>

namespace marco::sim {
namespace {

double draw_sign(std::mt19937_64& random) {
  return std::uniform_real_distribution<double>(-1.0, 1.0)(random) < 0.0 ? -1.0 : 1.0;
}

double draw_slip_m(const OdometryOptions& options, std::mt19937_64& random) {
  if (options.slip_every_m <= 0.0) return std::numeric_limits<double>::infinity();
  return std::exponential_distribution<double>(1.0 / options.slip_every_m)(random);
}

}  // namespace

OdometryModel::OdometryModel(const OdometryOptions& options,
                             const Pose2& world_from_robot,
                             std::mt19937_64& random)
    : options_(options),
      distance_scale_(1.0 + draw_sign(random) * options.distance_error),
      turn_scale_(1.0 + draw_sign(random) * options.turn_error),
      drift_rad_per_m_(draw_sign(random) * deg_to_rad(options.drift_deg_per_m)),
      to_next_slip_m_(draw_slip_m(options, random)),
      world_from_robot_(world_from_robot) {
  validate(options, "odometry");
}

const Pose2& OdometryModel::move_to(const Pose2& world_from_robot, std::mt19937_64& random) {
  const Pose2 step = between(world_from_robot_, world_from_robot);
  world_from_robot_ = world_from_robot;
  const double distance_m = step.translation_m().norm();
  odom_from_robot_ =
      odom_from_robot_ * Pose2{distance_scale_ * step.x_m, distance_scale_ * step.y_m,
                               turn_scale_ * step.theta_rad + drift_rad_per_m_ * distance_m};
  to_next_slip_m_ -= distance_m;
  if (to_next_slip_m_ <= 0.0) {
    odom_from_robot_ =
        odom_from_robot_ *
        Pose2{options_.slip_m, 0.0, draw_sign(random) * deg_to_rad(options_.slip_turn_deg)};
    to_next_slip_m_ = draw_slip_m(options_, random);
  }
  return odom_from_robot_;
}

}  // namespace marco::sim
