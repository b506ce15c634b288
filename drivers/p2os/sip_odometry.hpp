#pragma once

#include <optional>

#include "common/samples.hpp"
#include "drivers/p2os/codec.hpp"
#include "drivers/p2os/models.hpp"

namespace marco::drivers::p2os {

/// The robot's own dead reckoning, unwrapped: steps between information packets, appended to one
/// path. Where the robot's origin is set again, nothing moves here.
class SipOdometry {
 public:
  OdometrySample add(const Sip& sip, const Model& model, Utime measured);
  /// The next packet is the first of a session.
  void restart() { last_.reset(); }

  void begin_leg();
  /// Since begin_leg(): straight on, and turned with all whole turns.
  double moved_m() const { return between(leg_start_, odom_from_robot_).x_m; }
  double turned_rad() const { return turned_rad_; }

 private:
  std::optional<Sip> last_;
  Pose2 odom_from_robot_;
  Pose2 leg_start_;
  double turned_rad_ = 0.0;
};

}  // namespace marco::drivers::p2os
