#pragma once

#include <optional>
#include <string>

#include "drivers/base/base_driver.hpp"
#include "drivers/base/course.hpp"
#include "drivers/base/speed_profile.hpp"

namespace marco::drivers {

/// Plans the speeds of a base with speed-controlled wheels: moves, turns and velocities are
/// trapezoids, closed by the wheels' ticks. No clock of its own.
class WheelPlan {
 public:
  /// From an order to the wheels and back.
  static constexpr double kDelayS = 0.1;
  static constexpr double kStepS = 0.05;

  struct LegEnd {
    bool reached = true;
    std::string why_not;
  };

  /// @param tick_m  of a wheel's way. @param track_m  between the wheels' middles.
  WheelPlan(double tick_m, double track_m) : tick_m_(tick_m), track_m_(track_m) {}

  void set_speeds(const BaseSpeeds& speeds);
  void start_leg(const BaseDriver::Leg& leg, const Pose2& odom_from_robot, Utime now);
  double leg_remaining(const Pose2& odom_from_robot) const;
  /// Goals that the speeds follow.
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s);
  /// Ends a leg; the speeds follow down to 0. came_to_stand() reports when.
  void stop();
  /// The speeds are 0 at once.
  void halt() { velocity_.speed = velocity_.goal = rate_.speed = rate_.goal = 0.0; }
  /// A bumper is pressed: what moves ahead stands at once; a turn continues.
  void cut_velocity() { velocity_.speed = 0.0; }
  /// Forgets what was under way.
  void stand();

  /// The wheels were counted.
  void note_motion(bool moved) { still_ = moved ? 0 : still_ + 1; }
  /// What they did to the pose. @returns the leg's end, once.
  std::optional<LegEnd> follow(const Pose2& before, const Pose2& after, bool moved, Utime now);
  /// True once after stop(), when the wheels stand.
  bool came_to_stand();

  /// Each kStepS: the speeds come nearer to their goals.
  void step(const Pose2& odom_from_robot);
  double velocity_m_per_s() const { return velocity_.speed; }
  double left_m_per_s() const { return velocity_.speed - rate_.speed * track_m_ / 2.0; }
  double right_m_per_s() const { return velocity_.speed + rate_.speed * track_m_ / 2.0; }
  BaseDynamics dynamics() const {
    return {velocity_.acceleration, velocity_.deceleration, rate_.acceleration, rate_.deceleration};
  }

 private:
  double still_to_go(const Pose2& odom_from_robot) const;
  bool ends(const Pose2& odom_from_robot, Utime now);

  double tick_m_, track_m_;
  SpeedProfile velocity_, rate_;
  std::optional<Course> course_;
  bool stopping_ = false;
  int still_ = 0;  ///< counts in a row without motion
};

}  // namespace marco::drivers
