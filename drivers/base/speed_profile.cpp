#include "drivers/base/speed_profile.hpp"

#include <algorithm>
#include <cmath>

namespace marco::drivers {

void SpeedProfile::step(std::optional<double> left, double dt_s) {
  const double wanted =
      left ? std::copysign(std::min(std::sqrt(2.0 * deceleration * std::abs(*left)), limit), *left)
           : std::clamp(goal, -limit, limit);
  const bool braking = std::abs(wanted) < std::abs(speed) || wanted * speed < 0.0;
  const double most = (braking ? deceleration : acceleration) * dt_s;
  speed += std::clamp(wanted - speed, -most, most);
}

void SpeedProfile::set_acceleration(double value) {
  if (value != 0.0) (value > 0.0 ? acceleration : deceleration) = std::abs(value);
}

}  // namespace marco::drivers
