#pragma once

#include <deque>

#include "common/pose2.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::sim {

/// The poses of the robot and its pan-tilt during the last second.
class MotionHistory {
 public:
  struct Moment {
    Utime when;
    Pose2 world_from_robot;
    double pan_rad = 0.0;
    double tilt_rad = 0.0;
  };
  void add(const Moment& moment);
  /// Interpolated; outside the known time the nearest end.
  Moment at(Utime when) const;

 private:
  std::deque<Moment> moments_;
};

}  // namespace marco::sim
