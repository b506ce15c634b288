#include "drivers/p2os/sip_odometry.hpp"

#include <cmath>

namespace marco::drivers::p2os {
namespace {

// Fifteen bits, unwrapped.
int difference(uint16_t now, uint16_t before) {
  const int d = (now - before) & 0x7FFF;
  return d >= 0x4000 ? d - 0x8000 : d;
}

}  // namespace

void SipOdometry::begin_leg() {
  leg_start_ = odom_from_robot_;
  turned_rad_ = 0.0;
}

OdometrySample SipOdometry::add(const Sip& sip, const Model& model, Utime measured) {
  if (last_) {
    const double mm = model.mm_per_distance * 1e-3;
    const double dx = difference(sip.x, last_->x) * mm;
    const double dy = difference(sip.y, last_->y) * mm;
    const double was = last_->heading * kRadPerHeading;
    const double turned = normalize_angle((sip.heading - last_->heading) * kRadPerHeading);
    constexpr double kMostM = 0.6;  // in a cycle, even when some are lost
    if (std::hypot(dx, dy) < kMostM) {
      const double c = std::cos(was), s = std::sin(was);
      odom_from_robot_ = odom_from_robot_ * Pose2{c * dx + s * dy, -s * dx + c * dy, turned};
      turned_rad_ += turned;
    }
  }
  last_ = sip;
  OdometrySample sample;
  sample.utime = measured;
  sample.odom_from_robot = odom_from_robot_;
  const double mm_per_s = model.mm_per_s_per_velocity;
  sample.velocity_m_per_s = (sip.left_speed + sip.right_speed) / 2.0 * mm_per_s * 1e-3;
  sample.yaw_rate_rad_per_s =
      (sip.right_speed - sip.left_speed) / 2.0 * mm_per_s * model.rad_per_mm_per_s;
  return sample;
}

}  // namespace marco::drivers::p2os
