#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <string>
#include <vector>

#include "drivers/base/arc.hpp"
#include "drivers/base/base_driver.hpp"

namespace marco::drivers::testing {

/// A base without a protocol, and the robot that it drives: its speeds follow an order, some time
/// later, by constant accelerations. Its odometry is exact.
class PlainBase : public BaseDriver {
 public:
  PlainBase(const GuardOptions& guard, double delay_s, const BaseSpeeds& speeds = {0.8, 1.2, 0.3})
      : BaseDriver("plain", speeds, guard), delay_s_(delay_s) {}

  void on_connection(bool connected, Utime now) override {
    set_link(connected ? BaseStatus::Link::up : BaseStatus::Link::down, "", now);
  }
  void receive(std::span<const uint8_t>, Utime) override {}
  std::vector<uint8_t> stop_bytes() const override { return {}; }
  int64_t bad_input() const override { return 0; }
  /// A control step.
  void advance(Utime now, std::vector<uint8_t>&) override {
    publish_odometry({now, world_from_robot, ahead_, turn_});
    advance_motion(now);
    if (leg_) follow_leg(now);
    if (stopping_ && ahead_ == 0.0 && turn_ == 0.0) {
      stopping_ = false;
      stopped(now);
    }
  }
  /// The robot moves for `dt_s`, up to `now`.
  void roll(double dt_s, Utime now) {
    const Utime in_effect = now - Duration::from_seconds(delay_s_);
    while (orders_.size() > 1 && orders_[1].when <= in_effect) orders_.pop_front();
    BaseVelocity goal;
    if (!orders_.empty() && orders_[0].when <= in_effect) goal = orders_[0].velocity;
    const BaseDynamics most = dynamics();
    ahead_ += std::clamp(goal.ahead_m_per_s - ahead_, -most.braking_m_per_s2 * dt_s,
                         most.braking_m_per_s2 * dt_s);
    turn_ += std::clamp(goal.turn_rad_per_s - turn_, -most.turn_braking_rad_per_s2 * dt_s,
                        most.turn_braking_rad_per_s2 * dt_s);
    world_from_robot = world_from_robot * along_arc(ahead_ * dt_s, turn_ * dt_s);
  }

  bool rests() const { return ahead_ == 0.0 && turn_ == 0.0; }
  BaseVelocity velocity() const { return {ahead_, turn_}; }
  /// What the wheels were told last.
  BaseVelocity told() const { return orders_.empty() ? BaseVelocity{} : orders_.back().velocity; }

  Pose2 world_from_robot;

 private:
  struct Order {
    Utime when;
    BaseVelocity velocity;
  };
  void tell_wheels(const BaseVelocity& velocity, Utime now) { orders_.push_back({now, velocity}); }
  void start_leg(const Leg& leg, Utime /*now*/) override {
    leg_ = leg;
    from_ = world_from_robot;
  }
  double leg_remaining() const override {
    const Pose2 done = between(from_, world_from_robot);
    return leg_ ? leg_->amount - (leg_->kind == Leg::Kind::move ? done.x_m : done.theta_rad) : 0.0;
  }
  void follow_leg(Utime now) {
    const bool moves = leg_->kind == Leg::Kind::move;
    const double speed = moves ? ahead_ : turn_, rest = leg_remaining() - delay_s_ * speed;
    const double braking = moves ? dynamics().braking_m_per_s2 : dynamics().turn_braking_rad_per_s2;
    const double limit = moves ? speeds().velocity_m_per_s : speeds().yaw_rate_rad_per_s;
    const bool there = std::abs(rest) < 0.005;
    const double wanted =
        there ? 0.0
              : std::copysign(std::min(limit, std::sqrt(1.6 * braking * std::abs(rest))), rest);
    tell_wheels(moves ? BaseVelocity{wanted, 0.0} : BaseVelocity{0.0, wanted}, now);
    if (!there || !rests()) return;
    leg_.reset();
    leg_ended(true, "", now);
  }
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) override {
    tell_wheels({velocity_m_per_s, yaw_rate_rad_per_s}, now);
  }
  void stop_wheels(Utime now) override {
    leg_.reset();
    stopping_ = true;
    tell_wheels({}, now);
  }
  BaseDynamics dynamics() const override { return {0.3, 0.3, 1.0, 1.0}; }

  double delay_s_;
  double ahead_ = 0.0, turn_ = 0.0;
  std::deque<Order> orders_;
  std::optional<Leg> leg_;
  Pose2 from_;
  bool stopping_ = false;
};

}  // namespace marco::drivers::testing
