#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/base/base_driver.hpp"
#include "drivers/base/click_odometry.hpp"
#include "drivers/base/speed_profile.hpp"

namespace marco::drivers {

/// Driver of a base whose two wheels turn as fast as they are told. The host plans: moves, turns
/// and velocities are trapezoids, closed by the wheels' ticks. A derived class has the protocol,
/// and says what makes driving unsafe. No clock of its own.
class DifferentialBase : public BaseDriver {
 public:
  void advance(Utime now, std::vector<uint8_t>& out) override;
  BaseDynamics dynamics() const override {
    return {velocity_.acceleration, velocity_.deceleration, rate_.acceleration, rate_.deceleration};
  }

 protected:
  static constexpr double kSilentS = 0.5;  ///< then the base is gone
  /// Of the wheels.
  struct WheelSpeeds {
    double left_m_per_s = 0.0, right_m_per_s = 0.0;
  };

  /// @param tick_m  of a wheel's way. @param track_m  between the wheels' middles.
  DifferentialBase(std::string name,
                   const BaseSpeeds& speeds,
                   const GuardOptions& guard,
                   double tick_m,
                   double track_m);

  /// The line was opened or lost, after begin_session().
  void note_line(bool connected, const std::string& waiting_for, Utime now);
  /// Nothing that was ordered before resumes.
  void begin_session(Utime now);
  /// Something was understood that left the base then.
  void note_sign_of_life(Utime left) { understood_ = left; }
  bool silent_for(double seconds, Utime now) const {
    return (now - understood_).seconds() > seconds;
  }
  /// At most once in so long, from begin_session() on.
  bool ask_is_due(double every_s, Utime now);
  void ask_later(double s, Utime now) { next_ask_ = now + Duration::from_seconds(s); }

  /// The wheels were counted. @param measured  by the base's clock. @param left  by the arrival
  void turned(const ClickOdometry::Step& step, Utime measured, Utime left);
  /// Bumpers in front. What moves ahead stands at once; a turn continues. @returns whether they
  /// changed.
  bool touched(const std::vector<bool>& pressed, Utime now);
  /// The link is up while nothing is unsafe. @returns whether it has just gone down.
  bool judge_link(const std::string& why_unsafe, const std::string& note, Utime now);
  /// Ends a leg that is there, or blocked: last of what follows from counted wheels.
  void follow_leg(Utime now);
  /// The base stands, and forgets what was under way.
  void stand();
  /// Speeds are sent at the next step.
  void send_at_once(Utime now) { next_motion_ = now; }
  double tick_m() const { return tick_m_; }
  double track_m() const { return track_m_; }

 private:
  /// Appends what brings the link up and keeps it. The line is open.
  virtual void keep_link(Utime now, std::vector<uint8_t>& out) = 0;
  /// Whether speeds are sent to it.
  virtual bool takes_speeds() const = 0;
  /// @param due  every kStepS; asked at each step.
  virtual void send_speeds(const WheelSpeeds& speeds, bool due, std::vector<uint8_t>& out) = 0;

  void start_leg(const Leg& leg, Utime now) final;
  double leg_remaining() const final {
    return course_ ? course_->remaining(odom_from_robot()) : 0.0;
  }
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) final;
  void stop_wheels(Utime now) final;
  void emergency_brake(Utime now) final;
  void speeds_changed() final;

  /// A leg under way.
  struct Course {
    Leg leg;
    Pose2 odom_from_start;
    Utime moved;               ///< when the wheels turned last
    double turned_rad = 0.0;   ///< since the start, whole turns too
    bool braking = false;      ///< it is there, or the wheels do not get there
    std::string why_not = {};  ///< "" = it is there

    bool turns() const { return leg.kind == Leg::Kind::turn; }
    /// The rest of the leg, signed [m or rad].
    double remaining(const Pose2& odom_from_robot) const {
      return leg.amount - (turns() ? turned_rad : between(odom_from_start, odom_from_robot).x_m);
    }
  };

  double still_to_go() const;
  bool ends(Utime now);
  void halt() { velocity_.speed = velocity_.goal = rate_.speed = rate_.goal = 0.0; }
  void step_speeds();

  double tick_m_, track_m_;
  bool connected_ = false;
  Utime understood_;  ///< when something was, last
  Utime next_ask_, next_motion_;
  ClickOdometry odometry_;
  SpeedProfile velocity_, rate_;
  std::optional<Course> course_;
  bool stopping_ = false;
  int still_ = 0;  ///< counts in a row without motion
};

}  // namespace marco::drivers
