#include "drivers/base/motion_forecast.hpp"

#include <algorithm>
#include <limits>

#include "drivers/base/arc.hpp"
#include "drivers/base/speed_profile.hpp"

namespace marco::drivers {
namespace {

constexpr double kStepM = 0.01, kLongestStepS = 0.02;
constexpr double kSmoothedS = 0.05;  // a measured velocity is worth as much as what is expected
constexpr std::size_t kMostSteps = 600;

}  // namespace

void MotionForecast::on_sent(const BaseVelocity& order, Utime now) {
  if (sent_.empty() ? order.is_zero() : sent_.back().order == order) return;
  sent_.push_back({now, order});
  const Utime in_effect_since = now - Duration::from_seconds(delay_s_);
  while (sent_.size() > 1 && sent_[1].when <= in_effect_since) sent_.pop_front();
}

BaseVelocity MotionForecast::in_effect(Utime now) const {
  BaseVelocity order;
  for (const Sent& sent : sent_) {
    if (sent.when > now - Duration::from_seconds(delay_s_)) break;
    order = sent.order;
  }
  return order;
}

BaseVelocity MotionForecast::after(const BaseVelocity& speed,
                                   const BaseVelocity& goal,
                                   double seconds) const {
  constexpr double kNoLimit = std::numeric_limits<double>::infinity();
  SpeedProfile ahead{kNoLimit, dynamics_.acceleration_m_per_s2, dynamics_.braking_m_per_s2,
                     speed.ahead_m_per_s, goal.ahead_m_per_s};
  SpeedProfile turn{kNoLimit, dynamics_.turn_acceleration_rad_per_s2,
                    dynamics_.turn_braking_rad_per_s2, speed.turn_rad_per_s, goal.turn_rad_per_s};
  ahead.step(std::nullopt, seconds);
  turn.step(std::nullopt, seconds);
  return {ahead.speed, turn.speed};
}

void MotionForecast::on_measured(const BaseVelocity& velocity, double since_s, Utime now) {
  const double fresh = std::clamp(since_s / kSmoothedS, 0.0, 1.0);
  const BaseVelocity expected =
      after(measured_, in_effect(now), std::clamp(since_s, 0.0, kSmoothedS));
  measured_ = {std::lerp(expected.ahead_m_per_s, velocity.ahead_m_per_s, fresh),
               std::lerp(expected.turn_rad_per_s, velocity.turn_rad_per_s, fresh)};
}

Sweep MotionForecast::stopping_way(const BaseVelocity& order,
                                   double order_s,
                                   Utime now,
                                   double radius_m) const {
  BaseVelocity speed = measured_;
  Sweep sweep(1);
  double step_s = 0.0;
  for (double t_s = 0.0; sweep.size() < kMostSteps; t_s += step_s) {
    const bool ordered = t_s < delay_s_ + order_s;
    if (!ordered && speed.is_zero()) break;
    step_s = std::clamp(kStepM / speed.fastest_m_per_s(radius_m), 1e-3, kLongestStepS);
    const BaseVelocity goal = t_s < delay_s_ ? in_effect(now + Duration::from_seconds(t_s))
                              : ordered      ? order
                                             : BaseVelocity{};
    const BaseVelocity next = after(speed, goal, step_s);
    const double ahead = (speed.ahead_m_per_s + next.ahead_m_per_s) / 2.0;
    const double turn = (speed.turn_rad_per_s + next.turn_rad_per_s) / 2.0;
    speed = next;
    if (ahead == 0.0 && turn == 0.0) continue;
    advance(sweep, along_arc(ahead * step_s, turn * step_s), radius_m);
  }
  return sweep;
}

}  // namespace marco::drivers
