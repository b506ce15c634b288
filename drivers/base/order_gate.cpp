#include "drivers/base/order_gate.hpp"

#include <algorithm>
#include <cmath>

#include "common/order_age.hpp"
#include "lcm_tools/base/printable.hpp"

namespace marco::drivers {
namespace {

using Kind = BaseCommand::Kind;

// Beyond these no robot indoors drives: such an order is a mistake in units, or worse.
constexpr double kMostVelocity = 10.0;  // m/s
constexpr double kMostRate = 20.0;      // rad/s
constexpr double kMostWay = 1000.0;     // m
constexpr double kMostTurn = 100.0;     // rad
constexpr double kMostAcceleration = 100.0;
constexpr std::size_t kMostStamps = 64;

bool within(double value, double most) { return std::abs(value) <= most; }  // false for NaN

/// Only the fields of its kind count.
bool drivable(const BaseCommand& order) {
  switch (order.kind) {
    case Kind::stop:
    case Kind::forget_sensors:
      return true;
    case Kind::move:
      return within(order.distance_m, kMostWay);
    case Kind::turn:
      return within(order.angle_rad, kMostTurn);
    case Kind::velocity:
      return within(order.velocity_m_per_s, kMostVelocity) &&
             within(order.yaw_rate_rad_per_s, kMostRate);
    case Kind::go_to:
      return within(order.point_m.x(), kMostWay) && within(order.point_m.y(), kMostWay);
    case Kind::set_speed:
      return within(order.max_velocity_m_per_s, kMostVelocity) &&
             within(order.max_yaw_rate_rad_per_s, kMostRate) &&
             within(order.acceleration_m_per_s2, kMostAcceleration);
  }
  return false;
}

}  // namespace

std::string OrderGate::why_refused(const BaseCommand& order, Utime now) const {
  if (order.kind == Kind::stop) return "";
  if (stopped() && order.kind != Kind::set_speed && order.kind != Kind::forget_sensors) {
    return "orders to move are refused until it is released (marco stop --release)";
  }
  if (!drivable(order)) {
    return "impossible for a robot: at most 10 m/s, 20 rad/s, 1000 m, 100 rad, 100 m/s2";
  }
  return why_stale(order.utime, now);
}

void OrderGate::engage(const EmergencyStop& message, Utime now) {
  if (engaged_.size() < kMostStamps) engaged_.insert(message.utime);
  latched_ = message;
  // A clock that is ahead must not keep the stop from being released.
  latched_->utime = std::min(message.utime, now);
  ignored_release_.clear();
}

bool OrderGate::on_emergency_stop(const EmergencyStop& message, Utime now) {
  const std::string before = note();
  if (message.engaged) {
    if (released_.contains(message.utime)) return false;
    engage(message, now);
  } else if (latched_ && message.utime < latched_->utime) {
    ignored_release_ =
        "; a release by " + printable(message.sender, Newline::escaped, 40) + " is older: ignored";
  } else if (latched_) {
    latched_.reset();
    if (released_.size() > kMostStamps) released_.clear();
    released_.merge(engaged_);
    engaged_.clear();
  }
  return note() != before;
}

std::string OrderGate::note() const {
  if (!latched_) return "";
  std::string text =
      kEmergencyStopNote + (" by " + printable(latched_->sender, Newline::escaped, 40));
  if (!latched_->reason.empty()) text += ": " + printable(latched_->reason, Newline::escaped, 120);
  return text + ignored_release_;
}

}  // namespace marco::drivers
