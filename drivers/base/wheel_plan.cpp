#include "drivers/base/wheel_plan.hpp"

#include <algorithm>
#include <cmath>

namespace marco::drivers {
namespace {

constexpr int kStill = 4;           // counts
constexpr double kNoMotionS = 1.0;  // then the wheels are blocked
constexpr double kCloseM = 0.003, kCloseRad = deg_to_rad(0.5);

}  // namespace

void WheelPlan::set_speeds(const BaseSpeeds& speeds) {
  velocity_.limit = speeds.velocity_m_per_s;
  velocity_.acceleration = velocity_.deceleration = speeds.acceleration_m_per_s2;
  rate_.limit = speeds.yaw_rate_rad_per_s;
  // The wheels' acceleration, at their distance from the middle.
  rate_.acceleration = rate_.deceleration = speeds.acceleration_m_per_s2 / (track_m_ / 2.0);
}

void WheelPlan::start_leg(const BaseDriver::Leg& leg, const Pose2& odom_from_robot, Utime now) {
  course_ = Course{leg, odom_from_robot, now};
  still_ = 0;
}

double WheelPlan::leg_remaining(const Pose2& odom_from_robot) const {
  return course_ ? course_->remaining(odom_from_robot) : 0.0;
}

// The wheels run on until an order reaches them.
double WheelPlan::still_to_go(const Pose2& odom_from_robot) const {
  return leg_remaining(odom_from_robot) -
         kDelayS * (course_->turns() ? rate_.speed : velocity_.speed);
}

void WheelPlan::drive(double velocity_m_per_s, double yaw_rate_rad_per_s) {
  velocity_.goal = velocity_m_per_s;
  rate_.goal = yaw_rate_rad_per_s;
}

void WheelPlan::stop() {
  course_.reset();
  velocity_.goal = rate_.goal = 0.0;
  stopping_ = true;
  still_ = 0;
}

void WheelPlan::stand() {
  course_.reset();
  stopping_ = false;
  halt();
}

bool WheelPlan::ends(const Pose2& odom_from_robot, Utime now) {
  // Half a tick of both wheels, where ticks are coarse.
  const double close =
      course_->turns() ? std::max(kCloseRad, tick_m_ / track_m_) : std::max(kCloseM, tick_m_ / 2.0);
  const double left = still_to_go(odom_from_robot);
  const bool there = std::abs(left) <= close || left * course_->leg.amount < 0.0;
  const bool blocked = (now - course_->moved).seconds() > kNoMotionS;
  if (!there && blocked) course_->why_not = "the wheels do not turn";
  return there || blocked;
}

std::optional<WheelPlan::LegEnd> WheelPlan::follow(const Pose2& before,
                                                   const Pose2& after,
                                                   bool moved,
                                                   Utime now) {
  if (!course_) return std::nullopt;
  course_->turned_rad += between(before, after).theta_rad;
  if (moved) course_->moved = now;
  if (!course_->braking) {
    if (!ends(after, now)) return std::nullopt;
    course_->braking = true;
    still_ = 0;
    halt();
  }
  if (still_ < kStill) return std::nullopt;
  const std::string why_not = course_->why_not;
  course_.reset();
  return LegEnd{why_not.empty(), why_not};
}

bool WheelPlan::came_to_stand() {
  const bool at_rest = velocity_.speed == 0.0 && rate_.speed == 0.0 && still_ >= kStill;
  if (!stopping_ || !at_rest) return false;
  stopping_ = false;
  return true;
}

void WheelPlan::step(const Pose2& odom_from_robot) {
  const bool follows = course_ && !course_->braking;
  const std::optional<double> left =
      follows ? std::optional(still_to_go(odom_from_robot)) : std::nullopt;
  velocity_.step(follows && !course_->turns() ? left : std::nullopt, kStepS);
  rate_.step(follows && course_->turns() ? left : std::nullopt, kStepS);
}

}  // namespace marco::drivers
