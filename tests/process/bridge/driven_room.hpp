#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <thread>

#include "common/pose2.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::testing {

/// A robot that stands until it is started and then drives a circle, in a room that is no two ways
/// alike.
class DrivenRoom {
 public:
  DrivenRoom() {
    world_.add_box(-3.0, -2.0, 4.0, 4.0);
    world_.add_box(2.0, -1.2, 2.7, -0.4);
    world_.add_box(-2.2, 2.6, -1.8, 3.4);
  }

  /// At `time_s`, unless it drives already.
  void start(double time_s) { starts_s_ = std::min(starts_s_, time_s); }
  double starts_s() const { return starts_s_; }

  Pose2 pose_at(double time_s) const {
    constexpr double kSpeed = 0.35, kYawRate = 0.35;
    const double turned = kYawRate * std::max(0.0, time_s - starts_s_);
    return {kSpeed / kYawRate * std::sin(turned), kSpeed / kYawRate * (1.0 - std::cos(turned)),
            normalize_angle(turned)};
  }
  /// @param bearing_rad  counter-clockwise from ahead @param from  of the laser in the robot
  double range_m(double time_s, double bearing_rad, const Pose2& from = {}) const {
    const Pose2 laser = pose_at(time_s) * from;
    return world_.range_m(laser.translation_m(), laser.theta_rad + bearing_rad);
  }

 private:
  FlatWorld world_;
  double starts_s_ = std::numeric_limits<double>::infinity();
};

/// Calls `step` with 0, 0.1, 0.2 ... s, twice as fast as that, until it returns true.
/// @returns whether it did within `most_s`
inline bool drive(double most_s, const std::function<bool(double)>& step) {
  auto next = std::chrono::steady_clock::now();
  for (double time_s = 0.0; time_s < most_s; time_s += 0.1) {
    if (step(time_s)) return true;
    next += std::chrono::milliseconds(50);
    std::this_thread::sleep_until(next);
  }
  return false;
}

}  // namespace marco::testing
