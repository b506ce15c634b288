#include "drivers/hcs12/ramp.hpp"

namespace marco::drivers::hcs12 {

void RampControl::start(int64_t target_clicks) {
  phase_ = Phase::accelerating;
  target_clicks_ = target_clicks;
  brake_point_ = target_clicks / 2;
  timer_ = ramp.step_ticks;
}

int RampControl::step(int64_t wheel_speed, int64_t clicks) {
  if (timer_ > 0) {
    --timer_;
    return 0;
  }
  timer_ = ramp.step_ticks;
  if (phase_ != Phase::accelerating) return phase_ == Phase::braking ? -1 : 0;
  if (wheel_speed + 3 >= ramp.top) {
    brake_point_ = target_clicks_ - clicks;
    phase_ = Phase::cruising;
  }
  return 1;
}

void RampControl::brake_if_due(int64_t clicks) {
  if (clicks >= brake_point_) phase_ = Phase::braking;
}

// A top speed within the dead zone would never move the wheel: such a walk would not end.
RampWalk::RampWalk(const Ramp& ramp, uint32_t target_clicks, Brake brake, Wheel wheel)
    : dead_zone_(wheel == Wheel::real && ramp.top > 1 ? 1 : 0),
      floor_(brake == Brake::to_start ? ramp.start : 0),
      speed_(ramp.start),
      wheel_speed_(wheel == Wheel::real ? 0 : ramp.start),
      done_(target_clicks == 0) {
  control_.ramp = ramp;
  control_.start(target_clicks);
}

void RampWalk::tick() {
  if (done_) return;
  ++ticks_;
  if (dead_zone_ == 0) {
    wheel_speed_ = speed_;
  } else if (speed_ > wheel_speed_ + dead_zone_) {
    ++wheel_speed_;
  } else if (speed_ < wheel_speed_ - dead_zone_) {
    --wheel_speed_;
  }
  clicks_ += wheel_speed_;
  const int change = control_.step(wheel_speed_, clicks_);
  if (change > 0 && speed_ < control_.ramp.top) ++speed_;
  if (change < 0 && speed_ > floor_) --speed_;
  control_.brake_if_due(clicks_);
  done_ = clicks_ >= control_.target_clicks() || (speed_ == 0 && wheel_speed_ <= dead_zone_);
}

void RampWalk::advance_to(int64_t ticks) {
  while (ticks_ < ticks && !done_) tick();
}

}  // namespace marco::drivers::hcs12
