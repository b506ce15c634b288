#include "slam/front_end/motion_guess.hpp"

#include <cmath>

namespace marco::slam {

std::optional<Velocity2> believed_velocity(const Pose2& moved,
                                           double dt_s,
                                           const MotionOptions& options) {
  const double limit_rad_per_s = deg_to_rad(options.max_turn_rate_deg_per_s);
  if (dt_s < 1e-3 || moved.translation_m().norm() > options.max_speed_m_per_s * dt_s ||
      std::abs(moved.theta_rad) > limit_rad_per_s * dt_s) {
    return std::nullopt;
  }
  return velocity_of(moved, dt_s);
}

}  // namespace marco::slam
