#pragma once

#include <string>

#include "drivers/base/base_driver.hpp"

namespace marco::drivers {

/// A leg under way.
struct Course {
  BaseDriver::Leg leg;
  Pose2 odom_from_start;
  Utime moved;               ///< when the wheels turned last
  double turned_rad = 0.0;   ///< since the start, whole turns too
  bool braking = false;      ///< it is there, or the wheels do not get there
  std::string why_not = {};  ///< "" = it is there

  bool turns() const { return leg.kind == BaseDriver::Leg::Kind::turn; }
  /// The rest of the leg, signed [m or rad].
  double remaining(const Pose2& odom_from_robot) const {
    return leg.amount - (turns() ? turned_rad : between(odom_from_start, odom_from_robot).x_m);
  }
};

}  // namespace marco::drivers
