#include "drivers/base/differential_base.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco::drivers {
namespace {

using Link = BaseStatus::Link;

constexpr double kDelayS = 0.1;  // from an order to the wheels and back
constexpr double kStepS = 0.05;
constexpr int kStill = 4;           // counts
constexpr double kNoMotionS = 1.0;  // then the wheels are blocked
constexpr double kCloseM = 0.003, kCloseRad = deg_to_rad(0.5);

}  // namespace

DifferentialBase::DifferentialBase(std::string name,
                                   const BaseSpeeds& speeds,
                                   const GuardOptions& guard,
                                   double tick_m,
                                   double track_m)
    : BaseDriver(std::move(name), speeds, guard),
      tick_m_(tick_m),
      track_m_(track_m),
      odometry_(tick_m, track_m) {
  DifferentialBase::speeds_changed();
}

void DifferentialBase::note_line(bool connected, const std::string& waiting_for, Utime now) {
  connected_ = connected;
  set_link(Link::down, connected ? "waiting for " + waiting_for : "the line is gone", now);
}

void DifferentialBase::begin_session(Utime now) {
  next_ask_ = understood_ = now;
  odometry_.forget_stamps();
  stand();
}

bool DifferentialBase::ask_is_due(double every_s, Utime now) {
  const bool due = now >= next_ask_;
  if (due) ask_later(every_s, now);
  return due;
}

void DifferentialBase::advance(Utime now, std::vector<uint8_t>& out) {
  if (connected_) keep_link(now, out);
  advance_motion(now);  // publishes the status without a line, too
  if (!connected_) return;
  const bool at_rest = velocity_.speed == 0.0 && rate_.speed == 0.0 && still_ >= kStill;
  if (stopping_ && at_rest) {
    stopping_ = false;
    stopped(now);
  }
  if (!takes_speeds()) return;
  const bool due = now >= next_motion_;
  if (due) {
    next_motion_ = now + Duration::from_seconds(kStepS);
    step_speeds();
  }
  const double apart = rate_.speed * track_m_ / 2.0;
  send_speeds({velocity_.speed - apart, velocity_.speed + apart}, due, out);
}

void DifferentialBase::step_speeds() {
  if (status().link != Link::up) return halt();
  const bool follows = course_ && !course_->braking;
  const std::optional<double> left = follows ? std::optional(still_to_go()) : std::nullopt;
  velocity_.step(follows && !course_->turns() ? left : std::nullopt, kStepS);
  rate_.step(follows && course_->turns() ? left : std::nullopt, kStepS);
}

void DifferentialBase::turned(const ClickOdometry::Step& step, Utime measured, Utime left) {
  const OdometrySample sample = odometry_.count(step, measured);
  const bool moved = step.left_clicks != 0.0 || step.right_clicks != 0.0;
  still_ = moved ? 0 : still_ + 1;
  if (course_) course_->turned_rad += between(odom_from_robot(), sample.odom_from_robot).theta_rad;
  if (course_ && moved) course_->moved = left;
  publish_odometry(sample);
}

bool DifferentialBase::touched(const std::vector<bool>& pressed, Utime now) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < pressed.size(); ++i) {
    if (pressed[i]) numbers.push_back(static_cast<int>(i) + 1);
  }
  guard().on_bumpers(numbers, {});
  if (!numbers.empty() && velocity_.speed > 0.0) {  // a ramp would push on
    velocity_.speed = 0.0;
    send_at_once(now);
  }
  return std::exchange(edit_status().bumpers, pressed) != pressed;
}

bool DifferentialBase::judge_link(const std::string& why_unsafe,
                                  const std::string& note,
                                  Utime now) {
  const bool safe = edit_status().motors_on = why_unsafe.empty();
  const BaseStatus before = status();
  if (before.link == (safe ? Link::up : Link::starting) && (safe || before.note == why_unsafe)) {
    return false;
  }
  stand();
  set_link(safe ? Link::up : Link::starting, safe ? note : why_unsafe, now);
  return !safe;
}

void DifferentialBase::start_leg(const Leg& leg, Utime now) {
  course_ = Course{leg, odom_from_robot(), now};
  still_ = 0;
}

// The wheels run on until an order reaches them.
double DifferentialBase::still_to_go() const {
  return leg_remaining() - kDelayS * (course_->turns() ? rate_.speed : velocity_.speed);
}

bool DifferentialBase::ends(Utime now) {
  // Half a tick of both wheels, where ticks are coarse.
  const double close =
      course_->turns() ? std::max(kCloseRad, tick_m_ / track_m_) : std::max(kCloseM, tick_m_ / 2.0);
  const double left = still_to_go();
  const bool there = std::abs(left) <= close || left * course_->leg.amount < 0.0;
  const bool blocked = (now - course_->moved).seconds() > kNoMotionS;
  if (!there && blocked) course_->why_not = "the wheels do not turn";
  return there || blocked;
}

void DifferentialBase::follow_leg(Utime now) {
  if (!course_) return;
  if (!course_->braking) {
    if (!ends(now)) return;
    course_->braking = true;
    still_ = 0;
    halt();
  }
  if (still_ < kStill) return;
  const std::string why_not = course_->why_not;
  course_.reset();
  leg_ended(why_not.empty(), why_not, now);
}

void DifferentialBase::drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime /*now*/) {
  velocity_.goal = velocity_m_per_s;
  rate_.goal = yaw_rate_rad_per_s;
}

void DifferentialBase::stop_wheels(Utime /*now*/) {
  course_.reset();
  velocity_.goal = rate_.goal = 0.0;
  stopping_ = true;
  still_ = 0;
}

void DifferentialBase::emergency_brake(Utime now) {
  stop_wheels(now);
  halt();
  send_at_once(now);
}

void DifferentialBase::stand() {
  course_.reset();
  stopping_ = false;
  halt();
}

void DifferentialBase::speeds_changed() {
  const BaseSpeeds limits = speeds();
  velocity_.limit = limits.velocity_m_per_s;
  velocity_.acceleration = velocity_.deceleration = limits.acceleration_m_per_s2;
  rate_.limit = limits.yaw_rate_rad_per_s;
  // The wheels' acceleration, at their distance from the middle.
  rate_.acceleration = rate_.deceleration = limits.acceleration_m_per_s2 / (track_m_ / 2.0);
}

}  // namespace marco::drivers
